"""The check of loads by other code: what was proven is verified, and nothing less."""

from dataclasses import replace

import numpy as np
import pytest

from pipeline.certify.recheck.loads import ON_BRANCH, verify_loads
from pipeline.certify.recheck.time_law import StatedMotion
from pipeline.machine import Machine
from pipeline.refine import Path
from pipeline.retime import Trajectory, measure_usage, prove_motion, time_reversed
from tests.certify.paths import line_path
from tests.rails import off_x
from tests.retime.proof.conftest import at_rest_at_both_ends


@pytest.fixture(scope="module")
def motion(line: Path) -> Trajectory:
    """Drive the short regular path against friction."""
    masses = replace(line.machine.masses, friction_n=np.full(5, 15.0))
    return at_rest_at_both_ends(replace(line, machine=replace(line.machine, masses=masses)))


@pytest.fixture(scope="module")
def stated(motion: Trajectory) -> StatedMotion:
    """State what is proven of it."""
    return _stated(motion)


def _stated(motion: Trajectory) -> StatedMotion:
    proof = prove_motion(motion, loads=True)
    return StatedMotion(proof.law_sha256, proof.fractions, proof.peaks)


def _refused(motion: Trajectory, stated: StatedMotion) -> set[str]:
    return {claim.what for claim in verify_loads(motion.path, motion.time_law, stated) if not claim.verified}


def test_what_was_proven_is_verified_there_and_back(motion: Trajectory, stated: StatedMotion) -> None:
    """Both ways, each with its own friction."""
    assert {"force", "link_force", "tcp_speed", "tcp_acceleration"} == set(stated.peaks)
    assert _refused(motion, stated) == set()
    back = time_reversed(motion)
    assert _refused(back, _stated(back)) == set()


def test_loads_on_rails_off_x_are_those_of_both_arithmetics_and_of_samples(machine: Machine) -> None:
    """Carts push along their rails, and hold their weight on them: bounds are above what floats find, and near."""
    masses = replace(machine.known_masses, friction_n=np.zeros(5))
    skewed = replace(off_x(machine), masses=masses)
    motion = at_rest_at_both_ends(line_path(skewed), 1.0)
    stated, peaks = _stated(motion), measure_usage(motion, 0.01).peaks
    assert _refused(motion, stated) == set()
    for name, bound in stated.peaks.items():
        assert (bound >= peaks[name] * (1.0 - 1e-6)).all()
        assert (bound <= 1.1 * peaks[name] + 1e-3).all()


@pytest.mark.parametrize("name", ["force", "link_force", "tcp_speed", "tcp_acceleration"])
def test_less_than_the_truth_is_refused(motion: Trajectory, stated: StatedMotion, name: str) -> None:
    """A twentieth of one subject, of the peaks or of the fractions."""
    words = f"{name.replace('_', ' ').replace('tcp', 'TCP')} stays within its bound and limit at every instant"
    less = {**stated.peaks, name: 0.95 * stated.peaks[name]}
    assert _refused(motion, replace(stated, peaks=less)) == {words}
    if name in stated.fractions:
        less = {**stated.fractions, name: 0.95 * stated.fractions[name]}
        assert _refused(motion, replace(stated, fractions=less)) == {words}


def test_what_is_limited_has_to_be_stated_within_its_limit(motion: Trajectory, stated: StatedMotion) -> None:
    """Nothing stated, or more than the limit, is not verified."""
    more = {**stated.fractions, "force": 1.1 * np.ones(5)}
    words = "force stays within its bound and limit at every instant"
    assert words in _refused(motion, replace(stated, fractions=more))
    assert words in _refused(motion, replace(stated, fractions={}, peaks={}))


def test_a_path_without_poses_is_refused(motion: Trajectory, stated: StatedMotion) -> None:
    """Known poses far from every solution: nothing can be followed, and nothing is verified."""
    path = replace(motion.path, node_pose=motion.path.node_pose + 50.0)
    assert _refused(replace(motion, path=path), stated) == {ON_BRANCH}
