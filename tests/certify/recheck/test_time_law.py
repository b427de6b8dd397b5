"""The check of a time law by other code: what was proven is verified, and nothing else is."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.interpolate import BSpline, PPoly

from pipeline.certify.recheck.time_law import LAW, LOCKED, ON_PATH, SMOOTH, StatedMotion, verify_time_law, within_limits
from pipeline.machine import Machine
from pipeline.refine import Path
from pipeline.retime import Trajectory, law_sha256, prove_motion, time_reversed
from pipeline.retime.result import stretched
from tests.retime.proof.conftest import (
    at_rest_at_both_ends,
    limited_to,
    of_degree_two,
    with_bump,
    with_corner,
    with_locked,
)

RATES = ("velocity", "acceleration", "jerk")


@pytest.fixture(scope="module")
def motion(line: Path) -> Trajectory:
    """Drive the short regular path within limits that it uses up to a thousandth."""
    wide = at_rest_at_both_ends(limited_to(line, 1.0, 1.0, 1.0))
    limits = 1.0005 * prove_motion(wide).use.attained.max(axis=1)
    return at_rest_at_both_ends(limited_to(line, *limits))


@pytest.fixture(scope="module")
def stated(motion: Trajectory) -> StatedMotion:
    """State what is proven of it."""
    proof = prove_motion(motion)
    return StatedMotion(proof.law_sha256, proof.fractions)


def _refused(motion: Trajectory, stated: StatedMotion | None, *, jerk: bool = True) -> set[str]:
    """Give the claims that are refused; without a statement, one that all limits are kept."""
    stated = stated or StatedMotion(law_sha256(motion), {name: np.ones(5) for name in RATES})
    claims = verify_time_law(motion.path, motion.time_law, law_sha256(motion), stated, jerk=jerk)
    return {claim.what for claim in claims if not claim.verified}


def test_what_was_proven_is_verified_there_and_back(motion: Trajectory, stated: StatedMotion) -> None:
    """Close to its limits: by a twentieth of a percent."""
    assert max(part.max() for part in stated.fractions.values()) > 0.999
    assert _refused(motion, stated) == set()
    back = time_reversed(motion)
    proof = prove_motion(back)
    assert _refused(back, StatedMotion(proof.law_sha256, proof.fractions)) == set()


@pytest.mark.parametrize("name", RATES)
def test_less_than_the_truth_is_refused(motion: Trajectory, stated: StatedMotion, name: str) -> None:
    """A twentieth of a percent, of one actuator."""
    less = stated.fractions[name] * np.where(np.arange(5) == int(np.argmax(stated.fractions[name])), 0.9994, 1.0)
    assert _refused(motion, replace(stated, fractions={**stated.fractions, name: less})) == {within_limits(name)}


def test_what_is_not_stated_is_not_verified(motion: Trajectory, stated: StatedMotion) -> None:
    """Nor is more than the whole limit, true as it may be."""
    without = {name: part for name, part in stated.fractions.items() if name != "jerk"}
    assert _refused(motion, replace(stated, fractions=without)) == {within_limits("jerk")}
    more = {**stated.fractions, "velocity": np.full(5, 1.1)}
    assert _refused(motion, replace(stated, fractions=more)) == {within_limits("velocity")}


def test_another_law_is_refused(motion: Trajectory, stated: StatedMotion) -> None:
    """By its hash, whatever it does; a spike of a tenth of a millisecond also by what it does."""
    law = motion.time_law
    other = replace(motion, time_law=PPoly(np.nextafter(law.c, 9.0), law.x))
    assert _refused(other, stated) == {LAW}
    later = replace(motion, time_law=PPoly(law.c, np.nextafter(law.x, 9.0 * (law.x > 0.0))))
    assert _refused(later, stated) == {LAW}
    spline = motion.path.spline
    bent = BSpline(np.nextafter(spline.t, 9.0 * ((spline.t > 0.0) & (spline.t < 1.0))), spline.c, spline.k)
    assert LAW in _refused(replace(motion, path=replace(motion.path, spline=bent)), stated)
    spiked = with_bump(motion, 1.2345, 1e-4, 3e-14)
    assert within_limits("jerk") in _refused(spiked, replace(stated, law_sha256=law_sha256(spiked)))


def test_a_law_a_little_too_fast_is_refused(motion: Trajectory, stated: StatedMotion) -> None:
    """0.15 %, which samples that are granted a thousandth would let pass; whatever is stated of it."""
    fast = stretched(motion, 0.9985 * motion.duration_s)
    words = {within_limits(name) for name in RATES}
    assert words <= _refused(fast, replace(stated, law_sha256=law_sha256(fast)))
    assert words <= _refused(fast, None)


def test_jumps_are_refused(motion: Trajectory, stated: StatedMotion) -> None:
    """Of the position within the motion, and of the velocity from rest."""
    split = with_bump(motion, 1.5, 1.0, 0.0)
    c = split.time_law.c.copy()
    c[-1, 1:] -= 1e-6
    jumping = replace(motion, time_law=PPoly(c, split.time_law.x))
    (wrong,) = _refused(jumping, replace(stated, law_sha256=law_sha256(jumping)))
    assert "jumps" in wrong


def test_limits_are_those_of_the_machine(machine: Machine, motion: Trajectory, stated: StatedMotion) -> None:
    """A machine with less of everything refuses all three."""
    slower = replace(motion, path=replace(motion.path, machine=machine))
    limits = machine.velocity_mps.max(), machine.acceleration_mps2.max(), machine.jerk_mps3.max()
    assert all(limit > 0.0 for limit in limits)
    weak = replace(slower, path=limited_to(motion.path, *(0.01 * np.ones(3))))
    assert _refused(weak, stated) == {within_limits(name) for name in stated.fractions}


def test_a_law_that_leaves_the_path_in_between_is_refused(motion: Trajectory) -> None:
    """Slow enough for all limits, it passes s = 1 by a third and turns back."""
    slow = stretched(at_rest_at_both_ends(motion.path), 400.0)
    away = with_bump(slow, 200.0, 199.0, 0.5)
    assert away.time_law(np.linspace(200.0, 400.0, 1_001)).max() > 1.3
    assert _refused(away, None) == {ON_PATH}


@pytest.mark.parametrize(("multiplicity", "refused"), [(3, set()), (4, {SMOOTH}), (5, {SMOOTH})])
def test_a_path_with_a_corner_is_refused(motion: Trajectory, multiplicity: int, refused: set[str]) -> None:
    """Of degree 5, with a knot in the middle of a piece of the law: at 4 its curvature jumps, at 5 its direction."""
    assert _refused(with_corner(motion, multiplicity), None) == refused


def test_without_jerk_limits_only_corners_of_the_direction_count(motion: Trajectory) -> None:
    """Accelerations jump by design."""
    free = replace(motion, path=limited_to(motion.path, 1.0, 1.0, np.inf))
    assert _refused(with_corner(free, 4), None) == set()
    assert _refused(with_corner(free, 5), None) == {SMOOTH}


def test_a_locked_actuator_that_moves_is_refused(motion: Trajectory) -> None:
    """No part of its limit is used, as there is none."""
    assert _refused(with_locked(motion, 3), None) == {LOCKED}


def test_accelerations_jump_only_where_jerk_is_not_to_be_limited(motion: Trajectory) -> None:
    """A law of degree two, slow enough for all limits: its degree does not decide what is asked of it."""
    abrupt = of_degree_two(motion, 60.0)
    assert _refused(abrupt, None, jerk=False) == set()
    assert _refused(abrupt, None) == {"the motion goes from rest to rest without jumps"}
