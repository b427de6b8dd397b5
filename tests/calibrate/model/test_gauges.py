"""What no measurement can tell."""

from collections.abc import Callable

import numpy as np
import pytest

from pipeline.calibrate.model.forward import close, position_jacobian
from pipeline.calibrate.model.gauges import fitted_gauges, gauges, rank
from pipeline.calibrate.model.parameters import CHOICES, USUAL
from tests.calibrate.conftest import Seen


@pytest.mark.parametrize("reflectors", [1, 2, 3])
def test_all_changes_that_are_not_seen_are_known(see: Callable[..., Seen], reflectors: int):
    """23 changes leave all that is seen as it is, and the rank of the data says that there are no others.

    With parallel rails there are 21, and without reflectors and offsets fewer still: always as many as by rank.
    """
    seen = see(reflectors, poses=60)
    model = seen.configured.with_frame(seen.simulated.truth.rotation, seen.simulated.truth.translation_m)
    q = seen.simulated.poses.q_m
    J = position_jacobian(model, q, close(model, q, seen.guess)).reshape(-1, model.parameters.count)
    rows = gauges(model)
    assert rows.shape == (23, model.parameters.count)
    np.testing.assert_allclose(J @ rows.T, 0.0, atol=1e-13)
    for kinds, expected in ((CHOICES, 23), (USUAL, 21), (("platform", "lengths"), 2), (("offsets", "reflectors"), 6)):
        is_fitted = model.parameters.is_fitted(kinds)
        found = fitted_gauges(model, is_fitted)
        np.testing.assert_allclose(J @ found.T, 0.0, atol=1e-12)
        np.testing.assert_allclose(found[:, ~is_fitted], 0.0, atol=1e-12)
        assert rank(J[:, is_fitted]) == is_fitted.sum() - len(found)
        if kinds in (CHOICES, USUAL):
            assert len(found) == expected


def test_gauges_of_rails_off_x_are_gauges(see: Callable[..., Seen]):
    """A machine whose rails have slopes turns with its encoders: nothing is seen of it, either."""
    seen = see(2, poses=20, direction_std_rad=3e-3)
    model, q = seen.simulated.truth, seen.simulated.poses.q_m
    assert np.abs(model.directions_rad).min() > 1e-4
    J = position_jacobian(model, q, close(model, q, seen.guess)).reshape(-1, model.parameters.count)
    np.testing.assert_allclose(J @ gauges(model).T, 0.0, atol=1e-12)


def test_joints_that_are_apart_do_not_slide(see: Callable[..., Seen]):
    """Where 3a and 3c have joints of their own on the cart, their joints on the platform cannot slide unseen."""
    truth = see(2, poses=5).simulated.truth
    assert (truth.cart_offsets_m[3] != truth.cart_offsets_m[5]).all()
    assert len(gauges(truth)) == 21
