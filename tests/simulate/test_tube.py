"""Whether a motion stays within the proven tube: contour errors count, lags do not."""

from dataclasses import replace

import numpy as np
import pytest

from pipeline.certify.recheck.tube import ProvenTube
from pipeline.machine import Machine
from pipeline.simulate import Deviations, Drives, Motion, Simulation, build_plant, simulate_motion
from pipeline.simulate.tube import check_tube
from tests.simulate.motions import part

WIDE, NARROW = (ProvenTube(np.full(5, eps), within_limits=False) for eps in (2.75e-3, 5e-4))


@pytest.fixture(scope="module")
def commanded(reference: Motion) -> Motion:
    """Take a second of the reference motion, in which all drives move."""
    return part(reference, 1_500, 2_501)


@pytest.fixture(scope="module")
def followed(agder: Machine, drives: Drives, commanded: Motion) -> Simulation:
    """Simulate no more than its first instants: tests put what the drives do in their place."""
    few = simulate_motion(agder, build_plant(agder, Deviations()), drives, part(commanded, 0, 3), standing_s=0.0)
    return replace(few, motion=commanded)


def _driven(followed: Simulation, q_m: np.ndarray) -> Simulation:
    """Let the drives be at positions (n, 5)."""
    period = followed.motion.period_s
    qdd = np.gradient(np.gradient(q_m, period, axis=0), period, axis=0)
    return replace(followed, q_m=q_m, qd_mps=np.gradient(q_m, period, axis=0), qdd_mps2=qdd)


def _late(motion: Motion, delay_s: float) -> np.ndarray:
    t = np.maximum(motion.t_s - delay_s, 0.0)
    return np.stack([np.interp(t, motion.t_s, q) for q in motion.q_m.T], axis=1)


@pytest.mark.parametrize("delay_s", [0.0, 0.0305, 0.1])
def test_being_late_together_is_no_error(followed: Simulation, delay_s: float) -> None:
    """Some micrometres are left of tens of millimetres."""
    simulation = _driven(followed, _late(followed.motion, delay_s))
    found = check_tube(simulation, NARROW)
    assert np.abs(found.contour_error_m).max() < 1e-6
    assert found.inside
    assert found.late_s[200:] == pytest.approx(delay_s, abs=1e-4)
    assert np.abs(simulation.following_error_m).max() >= 0.2 * delay_s


def test_one_that_is_late_alone_is_an_error(followed: Simulation) -> None:
    """Shared out among all drives by being late or early, but not gone; never more than the lag itself."""
    q = followed.motion.q_m.copy()
    q[:, 3] = _late(followed.motion, 0.02)[:, 3]
    simulation = _driven(followed, q)
    found = check_tube(simulation, NARROW)
    lag = np.abs(simulation.following_error_m).max()
    assert 0.2 * lag < np.abs(found.contour_error_m).max() <= lag
    assert found.inside == (found.share.max() <= 1.0)


@pytest.mark.parametrize(("eps_m", "inside"), [(4.9e-4, True), (2e-3, False)])
def test_errors_across_the_path_cannot_be_made_up_for(followed: Simulation, eps_m: float, inside: bool) -> None:
    """A wave in one drive, with a frequency that no lag follows."""
    motion = followed.motion
    wave = eps_m * np.sin(2.0 * np.pi * 3.0 * motion.t_s)
    found = check_tube(_driven(followed, motion.q_m + np.outer(wave, [0.0, 0.0, 0.0, 0.0, 1.0])), NARROW)
    assert found.inside == inside


def test_the_share_holds_between_the_periods_for_one_continuous_course(followed: Simulation) -> None:
    """With u linear in between, dense samples of both motions stay below the share; u only goes on."""
    motion = followed.motion
    random = np.random.default_rng(4)
    phases = random.uniform(0.0, 2.0 * np.pi, 5)
    wave = 3e-4 * np.sin(2.0 * np.pi * 2.0 * motion.t_s[:, None] + phases)
    simulation = _driven(followed, _late(motion, 0.01) + wave)
    found = check_tube(simulation, NARROW)
    u = motion.t_s - found.late_s
    assert (np.diff(u) >= -1e-12).all()
    t = np.linspace(0.0, motion.t_s[-1], 7_919)
    path, real = (
        np.stack([np.interp(at, motion.t_s, q) for q in values.T], axis=1)
        for at, values in ((np.interp(t, motion.t_s, u), motion.q_m), (t, simulation.q_m))
    )
    row = np.minimum((t / motion.period_s).astype(int), len(motion) - 1)
    assert (np.abs(path - real).max(axis=1) / 5e-4 <= found.share[row] + 1e-12).all()


def test_the_reference_machine_stays_within_what_is_proven(agder: Machine, drives: Drives, reference: Motion) -> None:
    """With the drives that are assumed, in the tube of 2.75 mm but not in one of half a millimetre."""
    simulation = simulate_motion(agder, build_plant(agder, Deviations()), drives, reference, standing_s=0.1)
    wide, narrow = (check_tube(simulation, tube) for tube in (WIDE, NARROW))
    assert wide.inside
    assert not narrow.inside
    assert wide.share[wide.worst] == wide.share.max()
    assert np.abs(wide.contour_error_m).max() <= np.abs(simulation.following_error_m).max()
