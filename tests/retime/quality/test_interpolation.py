"""What a controller makes of rows: bounds that hold, of known order, and a motion slow enough for all of them."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.interpolate import BPoly, CubicHermiteSpline

from pipeline.errors import UnfitConfigError
from pipeline.refine.result import Path
from pipeline.retime import (
    Interpolation,
    Trajectory,
    interpolations,
    safe_to_interpolate,
    sample_trajectory,
    whole_periods,
)
from tests.retime.proof.conftest import at_rest_at_both_ends, limited_to, of_degree_two

_PERIOD_S = 0.05


@pytest.fixture(scope="module")
def moving(path: Path) -> Trajectory:
    """Drive the curve within limits that its samples just keep."""
    probe = at_rest_at_both_ends(path)
    t = np.linspace(0.0, probe.duration_s, 4_001)
    peaks = [float(np.abs(probe.q(t, order)).max()) for order in (1, 2, 3)]
    return at_rest_at_both_ends(limited_to(path, *(1.0001 * np.array(peaks))))


def _found(trajectory: Trajectory, period_s: float = _PERIOD_S) -> dict[str, Interpolation]:
    fitted = whole_periods(trajectory, period_s)
    return {one.method: one for one in interpolations(fitted, sample_trajectory(fitted, period_s))}


def test_bounds_are_those_of_other_code(moving: Trajectory) -> None:
    """SciPy's interpolations, sampled densely, reach 99 % of every bound and never more."""
    rows, found, limits = sample_trajectory(moving, _PERIOD_S), _found(moving), moving.path.machine
    t = np.linspace(0.0, moving.duration_s, 40_001)[1:-1]
    cubic = CubicHermiteSpline(rows.t_s, rows.q_m, rows.qd_mps)
    quintic = BPoly.from_derivatives(rows.t_s, np.stack([rows.q_m, rows.qd_mps, rows.qdd_mps2], 1))
    for method, function in (("cubic", cubic), ("quintic", quintic)):
        seen = np.abs(function(t) - moving.q(t)).max(axis=0)
        assert (seen <= found[method].deviation_m).all()
        assert (found[method].deviation_m <= 1.15 * seen + 1e-12).all()
        for order, limit in ((1, limits.velocity_mps), (2, limits.acceleration_mps2), (3, limits.jerk_mps3)):
            name = ("velocity", "acceleration", "jerk")[order - 1]
            seen = np.abs(function(t, order)).max(axis=0) / limit
            assert (seen <= found[method].usage[name] * (1.0 + 1e-9)).all()
            assert (found[method].usage[name] <= 1.01 * seen + 1e-6).all()


@pytest.mark.parametrize("dwell_s", [0.249, 0.247, 0.21])
def test_rows_may_lie_beside_the_beginning_and_the_end_of_the_motion(moving: Trajectory, dwell_s: float) -> None:
    """Polynomials leave the start before the motion does: that is as far off as they are in it."""
    waiting = whole_periods(replace(moving, dwell_s=(dwell_s, dwell_s)), _PERIOD_S)
    rows, found = sample_trajectory(waiting, _PERIOD_S), _found(waiting)
    t = np.linspace(0.0, waiting.duration_s, 40_001)[1:-1]
    quintic = BPoly.from_derivatives(rows.t_s, np.stack([rows.q_m, rows.qd_mps, rows.qdd_mps2], 1))
    for method, function in (("cubic", CubicHermiteSpline(rows.t_s, rows.q_m, rows.qd_mps)), ("quintic", quintic)):
        seen = np.abs(function(t) - waiting.q(t)).max(axis=0)
        assert (seen <= found[method].deviation_m).all()
        assert (found[method].deviation_m <= 1.2 * seen + 1e-12).all()


def test_deviations_fall_with_the_period(moving: Trajectory) -> None:
    """By its square for lines, and by its fourth power at least for cubics and quintics."""
    coarse, fine = _found(moving), _found(moving, _PERIOD_S / 2.0)
    for method, order in (("linear", 2.0), ("cubic", 4.0), ("quintic", 4.0)):
        found = np.log2(coarse[method].deviation_m / fine[method].deviation_m)
        assert (found > order - 0.35).all()


def test_what_jumps_at_the_rows(moving: Trajectory) -> None:
    """Velocities of lines by about acceleration times period, accelerations of cubics; quintics jump in jerk only."""
    found = _found(moving)
    assert [one.jump[0] for one in found.values()] == ["velocity_mps", "acceleration_mps2", "jerk_mps3"]
    acceleration = np.abs(moving.q(np.linspace(0.0, 4.0, 2_001), 2)).max(axis=0)
    np.testing.assert_allclose(found["linear"].jump[1], acceleration * _PERIOD_S, rtol=0.1)
    assert list(found["linear"].usage) == ["velocity"]


def test_a_warning_names_interpolation_period_and_limit(moving: Trajectory) -> None:
    """Between rows far apart cubics exceed what the motion keeps; near each other they do not."""
    warning = _found(moving, 0.2)["cubic"].warning
    assert warning.startswith("rows 0.2 s apart, interpolated by cubic polynomials, take ")
    assert warning.endswith("% of its acceleration limit")
    assert _found(moving, 0.002)["cubic"].warning == ""


def test_a_safe_motion_is_a_little_slower_and_keeps_all_limits(moving: Trajectory) -> None:
    """By whichever interpolation its rows are read."""
    safe = safe_to_interpolate(moving, _PERIOD_S)
    assert 1.0 < safe.motion_s / moving.motion_s < 1.2
    assert max(one.largest for one in _found(safe).values()) <= 1.0


def test_without_limits_of_jerk_none_is_reported(moving: Trajectory) -> None:
    """A law whose accelerations jump: its cubics have no limit of jerk to keep."""
    found = _found(of_degree_two(moving, 10.0))
    assert "jerk" not in found["quintic"].usage


def test_rows_that_would_be_too_many_are_refused(moving: Trajectory) -> None:
    """Limits so low that the motion takes more periods than a table may have rows."""
    tight = at_rest_at_both_ends(limited_to(moving.path, 1e-12, 1e-12, 1e-12))
    with pytest.raises(UnfitConfigError, match="rows"):
        safe_to_interpolate(tight, _PERIOD_S)
