"""The proof of loads: bounds that hold for forces and the TCP at every instant, near those sampled."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.interpolate import make_interp_spline

from pipeline.arrays import FloatArray
from pipeline.errors import NoSolutionError
from pipeline.machine.kinematics import follow, newton
from pipeline.refine.result import Path
from pipeline.retime import Trajectory, measure_usage, require_proven, time_reversed
from pipeline.retime.proof.load_use import LoadUse
from pipeline.retime.proof.motion_loads import prove_loads
from pipeline.retime.result import stretched
from tests.retime.proof.conftest import at_rest_at_both_ends, limited_to, with_bump


@pytest.fixture(scope="module")
def moving(path: Path) -> Trajectory:
    """Drive a little of the curve, there and halfway back, against friction: drives turn on the way."""
    s = np.linspace(0.0, 1.0, 6)
    along = 0.12 * s * (1.5 - s)
    short = replace(path, spline=make_interp_spline(s, path.q(along), k=5), node_s=s, node_pose=path.pose(along))
    masses = replace(path.machine.masses, friction_n=np.array([20.0, 20.0, 20.0, 50.0, 50.0]))
    wide = limited_to(short, 10.0, 100.0, 10_000.0).machine
    machine = replace(wide, masses=masses, tcp_speed_mps=5.0, force_n=np.full((2, 5), 2_000.0))
    return at_rest_at_both_ends(replace(short, machine=machine), 1.0)


@pytest.fixture(scope="module")
def proven(moving: Trajectory) -> LoadUse:
    """Prove its loads."""
    use = prove_loads(moving)
    assert use is not None
    return use


def test_bounds_hold_and_are_near_what_is_sampled(moving: Trajectory, proven: LoadUse) -> None:
    """Above every sample, limited or not; without friction that turns, by at most a tenth."""
    peaks = measure_usage(moving, 0.002).peaks
    friction = np.append(moving.path.machine.masses.friction_n, np.zeros(6))
    assert set(proven.peaks) == {"force", "link_force", "tcp_speed", "tcp_acceleration"}
    for name, bound in proven.peaks.items():
        room = 2.0 * friction[:5] if name == "force" else 0.0
        assert (bound >= peaks[name] * (1.0 - 1e-6)).all()
        assert (bound <= 1.1 * peaks[name] + room).all()


def test_limits_turn_bounds_into_fractions(moving: Trajectory, proven: LoadUse) -> None:
    """Of what has a limit; the TCP's acceleration has none."""
    limits = {"force": 2_000.0, "link_force": moving.path.machine.link_force_n, "tcp_speed": 5.0}
    assert set(proven.fractions) == set(limits)
    for name, limit in limits.items():
        np.testing.assert_allclose(proven.fractions[name] * np.max(limit), proven.peaks[name], rtol=1e-9)


def test_the_way_back_has_the_same_loads_but_for_friction(moving: Trajectory) -> None:
    """Reversed in time forces are the same without friction, and the curve is bounded once."""
    rubbed = moving.path
    free = replace(rubbed.machine, masses=replace(rubbed.machine.masses, friction_n=np.zeros(5)))
    there = replace(moving, path=replace(rubbed, machine=free))
    both = [prove_loads(one) for one in (there, time_reversed(there))]
    assert both[0] is not None
    assert both[1] is not None
    np.testing.assert_allclose(both[1].attained, both[0].attained, rtol=1e-3)
    np.testing.assert_allclose(both[1].proven, both[0].proven, rtol=1e-3)


def test_the_same_drives_in_another_assembly_have_other_loads(moving: Trajectory, proven: LoadUse) -> None:
    """What was bounded of one path is not taken for that of another with the same splines."""
    path = moving.path
    begins, _ = newton(path.machine, path.q(0.0)[None], np.array([[0.84, -0.32, 1.08, 0.0, -2.64, 0.0]]))
    poses, _ = follow(path.machine, path.q(path.node_s)[None], begins)
    other = replace(moving, path=replace(path, node_pose=poses[0]))
    use = prove_loads(other)
    assert use is not None
    assert (use.peaks["force"] >= measure_usage(other, 0.02).peaks["force"] * (1.0 - 1e-6)).all()
    assert not np.allclose(use.attained, proven.attained, rtol=1e-3)


def _limited(moving: Trajectory, force_n: float) -> Trajectory:
    machine = replace(moving.path.machine, force_n=np.full((2, 5), force_n))
    return replace(moving, path=replace(moving.path, machine=machine))


def test_a_force_above_its_limit_is_refused_with_the_place(moving: Trajectory, proven: LoadUse) -> None:
    """Names the drive, s and t; slowed down by the factor it gives, the motion is proven."""
    peaks: FloatArray = proven.peaks["force"]
    tight = _limited(moving, 0.95 * float(peaks.max()))
    worst = ("c1", "c2", "c3", "l2b", "l3b")[int(peaks.argmax())]
    with pytest.raises(
        NoSolutionError, match=rf"{worst} is not proven to keep its force limit .* s = 0\.\d+, t = "
    ) as error:
        require_proven(tight, loads=True)
    assert error.value.diagnosis["limit"] == "force"
    use = prove_loads(tight)
    assert use is not None
    assert 1.0 < use.stretch < 2.0
    require_proven(stretched(tight, use.stretch * 1.0001 * tight.duration_s), loads=True)


def test_a_spike_between_samples_is_refused(moving: Trajectory) -> None:
    """A push of a tenth of a millisecond that no sample of a period sees."""
    spiked = with_bump(moving, 0.40042, 1e-4, 1e-8)
    assert measure_usage(spiked, 0.01).fractions["force"].max() < 0.9
    with pytest.raises(NoSolutionError, match=r"t = 0\.400"):
        require_proven(spiked, loads=True)


def test_without_masses_only_the_tcp_is_bounded(moving: Trajectory) -> None:
    """And nothing at all if it has no limits."""
    bare = replace(moving.path.machine, masses=None)
    use = prove_loads(replace(moving, path=replace(moving.path, machine=bare)))
    assert use is not None
    assert set(use.peaks) == {"tcp_speed", "tcp_acceleration"}
    none = replace(bare, tcp_speed_mps=np.inf)
    assert prove_loads(replace(moving, path=replace(moving.path, machine=none))) is None
