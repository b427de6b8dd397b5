"""The machine that explains what a tracker saw."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from pipeline.arrays import FloatArray
from pipeline.calibrate.calibration import Setting
from pipeline.calibrate.identify import Identification, identify
from pipeline.calibrate.model.forward import close, positions
from pipeline.calibrate.model.model import Model
from pipeline.calibrate.model.parameters import TRACKER
from pipeline.errors import NoSolutionError
from tests.calibrate.conftest import Seen


def places_elsewhere(seen: Seen, model: Model) -> FloatArray:
    """See a machine's reflectors at poses that were not measured."""
    return positions(model, close(model, seen.simulated.poses.q_m, seen.guess))


def true_deviations(found: Identification, truth: Model) -> FloatArray:
    """Give the true deviations from the machine as configured, in the frame that was estimated first."""
    start = found.problem.model
    theta = truth.values() - start.values()
    turned = Rotation.from_matrix(truth.rotation @ start.rotation.T).as_rotvec()
    theta[start.parameters.slice(TRACKER)] = [*turned, *(truth.translation_m - start.translation_m)]
    return theta


@pytest.mark.parametrize("reflectors", [1, 2, 3])
def test_without_noise_the_machine_is_exact(see: Callable[..., Seen], reflectors: int):
    """Exact points give a machine that is where the true one is to 1e-9, also where nothing was measured."""
    seen, other = see(reflectors, poses=60, noise_m=0.0), see(reflectors, poses=60, seed=0, noise_m=0.0)
    found = identify(seen.problem(Setting(noise_m=1e-9)))
    assert np.abs(found.residual_m).max() < 1e-9
    elsewhere = see(reflectors, poses=30, seed=1)
    np.testing.assert_allclose(
        places_elsewhere(elsewhere, found.model), places_elsewhere(elsewhere, other.simulated.truth), atol=1e-9
    )


def test_a_machine_as_configured_is_left_as_it_is(see: Callable[..., Seen]):
    """With nothing off and no noise nothing changes, to 1e-9."""
    seen = see(2, poses=40, noise_m=0.0, geometry_std_m=0.0, scale_std=0.0)
    found = identify(seen.problem(Setting()))
    np.testing.assert_allclose(found.theta, 0.0, atol=1e-9)
    assert found.chi2 < 1e-9


def test_the_order_of_poses_does_not_matter(see: Callable[..., Seen]):
    """Rows in another order give the same machine and covariance to 1e-9 of their deviations."""
    problem = see(2).problem(Setting())
    rows = np.random.default_rng(3).permutation(len(problem.poses))
    other = replace(problem, poses=problem.poses.at(rows), guess=problem.guess[rows], weights=problem.weights[rows])
    first, second = identify(problem), identify(other)
    std = np.where(problem.is_fitted, first.std, 1.0)
    np.testing.assert_allclose(second.theta / std, first.theta / std, rtol=0.0, atol=1e-9)
    np.testing.assert_allclose(second.covariance / np.outer(std, std), first.covariance / np.outer(std, std), atol=1e-9)


def test_covariance_is_that_of_repeated_measurements(see: Callable[..., Seen]):
    """Points that were not seen do not count, and what is not fitted stays and has no deviation."""
    seen = see(2)
    whole = identify(seen.problem(Setting()))
    problem = seen.problem(Setting(fit=("platform", "lengths")))
    hidden = np.zeros(problem.poses.is_seen.shape, dtype=bool)
    hidden[::3, 0] = True
    found = identify(replace(problem, poses=problem.poses.without(hidden)))
    assert np.isnan(found.residual_m[hidden]).all()
    assert found.freedom == 3 * (~hidden).sum() - 6
    fixed = ~problem.is_fitted
    assert not found.theta[fixed].any()
    assert not found.std[fixed].any()
    assert (whole.std[whole.problem.is_fitted] > 0.0).all()
    assert (whole.std <= whole.problem.prior_std * (1.0 + 1e-9)).all()


def test_a_machine_that_cannot_be_assembled_is_reported(see: Callable[..., Seen]):
    """Encoders that no machine near the configured one can have end with the pose where it is, and what to do."""
    problem = see(2).problem(Setting())
    q = problem.poses.q_m.copy()
    q[7, 3] += 1.0
    apart = replace(problem, poses=replace(problem.poses, q_m=q))
    with pytest.raises(NoSolutionError, match=r"can be assembled at all poses: row 7 is one of 1"):
        identify(apart)


def _another(seen: Seen, seed: int) -> Seen:
    """Measure another machine at the same poses: off by what is known beforehand, seen by a tracker elsewhere."""
    random, model = np.random.default_rng(seed), seen.configured
    setting, parameters = Setting(), model.parameters
    std = np.where(parameters.is_fitted(setting.fit), parameters.prior_std({}), 0.0)
    theta = random.normal(size=parameters.count) * np.where(np.isfinite(std), std, 0.0)
    frame = Rotation.random(random_state=random).as_matrix(), random.uniform(-3.0, 3.0, 3)
    truth, q = model.moved(theta).with_frame(*frame), seen.simulated.poses.q_m
    where = positions(truth, close(truth, q, seen.guess))
    poses = replace(seen.simulated.poses, seen_m=where + random.normal(0.0, setting.noise_m, where.shape))
    return replace(seen, simulated=replace(seen.simulated, poses=poses, truth=truth))


def _over_machines(see: Callable[..., Seen], reflectors: int, count: int) -> tuple[FloatArray, FloatArray, list[int]]:
    """Calibrate machines: errors in units of their covariance, of points elsewhere in deviations, and evaluations."""
    errors, deviates, evaluations = [], [], []
    poses, elsewhere = see(reflectors), see(reflectors, poses=60, seed=1000)
    for seed in range(count):
        seen = _another(poses, seed)
        found = identify(seen.problem(Setting()))
        fitted = found.problem.is_fitted
        off = (found.theta - true_deviations(found, seen.simulated.truth))[fitted]
        errors.append(off @ np.linalg.solve(found.covariance[np.ix_(fitted, fitted)], off) / len(off))
        covariance = found.predicted_covariance(elsewhere.simulated.poses, elsewhere.guess)
        std = np.sqrt(np.diagonal(covariance, axis1=2, axis2=3))
        away = places_elsewhere(elsewhere, found.model) - places_elsewhere(elsewhere, seen.simulated.truth)
        deviates.append((away / std).ravel())
        evaluations.append(found.evaluations)
    return np.array(errors), np.array(deviates), evaluations


def test_the_covariance_is_about_right(see: Callable[..., Seen]):
    """A few machines say so: squared errors are 0.8 to 1.2 times what is stated, within five evaluations."""
    errors, deviates, evaluations = _over_machines(see, 2, 10)
    assert 0.8 < errors.mean() < 1.2
    assert 0.85 < (np.abs(deviates) < 1.96).mean() < 0.99
    assert max(evaluations) <= 5


@pytest.mark.slow
@pytest.mark.parametrize("reflectors", [1, 2, 3])
def test_the_covariance_is_honest(see: Callable[..., Seen], reflectors: int):
    """Over 50 machines errors are as large as stated: squared 0.9 to 1.1 times, and 93 to 97 % within 1.96 deviations.

    The machine is computed at most five times for each.
    """
    errors, deviates, evaluations = _over_machines(see, reflectors, 50)
    assert 0.9 < errors.mean() < 1.1
    assert 0.93 < (np.abs(deviates) < 1.96).mean() < 0.97
    assert 0.9 < np.sqrt((deviates**2).mean()) < 1.1
    assert max(evaluations) <= 5
