"""Points that are not where anything was."""

from collections.abc import Callable

import numpy as np

from pipeline.calibrate.calibration import Setting
from pipeline.calibrate.identify import identify
from pipeline.calibrate.robust import identify_robustly, most_deviations
from tests.calibrate.conftest import Seen


def test_outliers_are_found_and_left_out(see: Callable[..., Seen]):
    """All points that are 50 mm off are rejected, no others, and the machine is that of the others alone."""
    for seed in range(2):
        seen = see(2, outliers=0.05, seed=seed)
        problem = seen.problem(Setting())
        found, rejected = identify_robustly(problem)
        np.testing.assert_array_equal(rejected, seen.simulated.is_outlier)
        clean = identify(found.problem)
        np.testing.assert_allclose(clean.theta, found.theta, atol=1e-12)
        assert found.chi2 < 1.4 * found.freedom
    assert identify(problem).chi2 > 1e4


def test_good_points_stay(see: Callable[..., Seen]):
    """Without outliers none is rejected, and the fit is the usual one."""
    for seed in range(2):
        problem = see(2, seed=seed).problem(Setting())
        found, rejected = identify_robustly(problem)
        assert not rejected.any()
        np.testing.assert_allclose(found.theta, identify(problem).theta, rtol=0.0, atol=1e-10)


def test_the_limit_grows_with_the_number_of_points():
    """Of more points a farther one is likely: one of a thousand measurements has one beyond."""
    limits = [most_deviations(count) for count in (1, 100, 10_000)]
    np.testing.assert_allclose(limits[0], 4.03, atol=0.01)
    assert limits == sorted(limits)
    away = np.linalg.norm(np.random.default_rng(1).normal(size=(20_000, 50, 3)), axis=2)
    assert (away > most_deviations(50)).any(axis=1).mean() < 2.5e-3
