"""What a calibration may change."""

import numpy as np
import pytest

from pipeline.calibrate.model.parameters import CHOICES, DIRECTIONS, KINDS, TRACKER, USUAL, Parameters


@pytest.mark.parametrize(("reflectors", "count"), [(1, 71), (2, 74), (3, 77)])
def test_all_kinds_are_there_once(reflectors: int, count: int):
    """Slices of the kinds follow each other, and every parameter has a name of its own and a unit."""
    parameters = Parameters(reflectors)
    assert parameters.count == count
    assert np.concatenate([np.arange(count)[parameters.slice(kind)] for kind in KINDS]).tolist() == list(range(count))
    assert len(set(parameters.names)) == count == len(parameters.units)
    assert set(parameters.units) == {"m", "1", "rad"}


def test_what_is_known_and_fitted_goes_by_kinds():
    """The tracker is always fitted and never known; a prior that is given counts for its kind alone."""
    parameters = Parameters(2)
    std, usual = parameters.prior_std({"scales": 5e-5}), parameters.prior_std({})
    changed = std != usual
    assert [name.split()[0] for name, one in zip(parameters.names, changed, strict=True) if one] == ["scale"] * 5
    assert np.isinf(parameters.of(TRACKER, std)).all()
    fitted = parameters.is_fitted(USUAL)
    assert not parameters.of(DIRECTIONS, fitted).any()
    assert fitted.sum() == parameters.count - 6
    assert parameters.is_fitted(()).sum() == 6
    assert parameters.is_fitted(CHOICES).all()
