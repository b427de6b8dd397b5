"""Poses to choose from, and what they would say."""

from collections.abc import Callable

import numpy as np
import pytest

from pipeline.calibrate import Setting
from pipeline.calibrate.predict.candidates import Candidates, choose, draw_candidates, known_beforehand, measured
from pipeline.config import Config
from tests.calibrate.conftest import Seen


@pytest.fixture(scope="module")
def among(see: Callable[..., Seen], quick_config: Config) -> Candidates:
    """Draw candidates for the machine as configured."""
    return draw_candidates(quick_config, see(2).configured, 5e-5, (4, 25.0))


def test_measuring_adds_information():
    """What is left is the inverse of the sum of both informations, as for any linear measurement."""
    random = np.random.default_rng(0)
    root, J = random.normal(size=(6, 6)), random.normal(size=(3, 6))
    covariance = root @ root.T
    np.testing.assert_allclose(measured(covariance, J), np.linalg.inv(np.linalg.inv(covariance) + J.T @ J), atol=1e-9)


def test_choices_are_worth_most(among: Candidates, see: Callable[..., Seen]):
    """The first choice shrinks the covariance more than any other pose, errors fall, and none is chosen twice."""
    covariance = known_beforehand(see(2).configured, Setting())
    rows, errors = choose(among, covariance, 4)
    gains = [np.linalg.slogdet(np.eye(6) + J @ covariance @ J.T)[1] for J in among.seen]
    assert rows[0] == np.argmax(gains)
    assert len(set(rows.tolist())) == 4
    assert (np.diff(errors) < 0.0).all()
    left = measured(covariance, among.seen[rows[0]])
    assert errors[1] == pytest.approx(among.error_m(left))


def test_what_is_not_fitted_is_known(see: Callable[..., Seen]):
    """Parameters that may not change have no variance; the tracker's frame has a large one."""
    model = see(2).configured
    std = np.sqrt(np.diagonal(known_beforehand(model, Setting(fit=("lengths",), prior={"lengths": 1e-3}))))
    assert set(std.tolist()) == {0.0, 1e-3, 10.0}
    assert np.count_nonzero(std == 1e-3) == 4
