"""A first motion along a path."""

import numpy as np

from pipeline.refine import Refinement
from pipeline.refine.timed.first_motion import AT_REST, first_clock, fit_motion
from pipeline.refine.timed.hull import least_motion_s


def test_it_follows_the_path_from_rest_to_rest(refinement: Refinement) -> None:
    """The clock runs on from start to goal, and the splines stay within millimetres of the path."""
    path = refinement.path
    clock = first_clock(path, 40)
    assert (clock.s[0], clock.s[-1]) == (0.0, 1.0)
    assert (np.diff(clock.s) >= 0.0).all()
    spline = fit_motion(path, clock, 40)
    tau = np.linspace(0.0, 1.0, 501)
    assert np.abs(spline(tau) - path.q(clock.s_at(tau))).max() < 5e-3
    for end, q in ((spline.c[:AT_REST], path.q(0.0)), (spline.c[-AT_REST:], path.q(1.0))):
        np.testing.assert_array_equal(end, np.tile(q, (AT_REST, 1)))
    assert 3.0 < least_motion_s(path.machine, spline) < 15.0


def test_times_and_places_are_looked_up_both_ways(refinement: Refinement) -> None:
    """One look-up undoes the other."""
    clock = first_clock(refinement.path, 40)
    s = np.linspace(0.01, 0.99, 50)
    np.testing.assert_allclose(clock.s_at(clock.tau_at(s)), s, atol=1e-9)
