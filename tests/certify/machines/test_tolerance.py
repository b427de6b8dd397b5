"""Calibration tolerances: proven by a chain, and below errors at which a machine fails."""

from dataclasses import replace

import numpy as np
import pytest

from pipeline.certify import Uncertainty
from pipeline.certify.machines.tolerance import largest_tolerance, search_problem, search_tolerances
from pipeline.certify.monte_carlo import failing_eps
from pipeline.certify.problem import build_problem
from pipeline.config import Config
from pipeline.inclusion.closure import working_precision
from pipeline.machine import Machine
from pipeline.refine import Path
from tests.certify.paths import RLL, START, TOWARDS_SINGULARITY, pose_path


def lengths(eps: float) -> Uncertainty:
    """Take lengths for uncertain."""
    return Uncertainty(length_m=eps)


@pytest.fixture(scope="module")
def hasty(wide: Config) -> Config:
    """Bisect coarsely, and draw few machines."""
    certify = wide.certify.model_copy(update={"tolerance_resolution": 0.3, "monte_carlo_samples": 3})
    return wide.model_copy(update={"certify": certify})


@pytest.mark.slow
def test_the_proven_tolerance_is_below_what_fails(hasty: Config, machine: Machine, line: Path) -> None:
    """And that of all coordinates is less than that of lengths alone."""
    with working_precision(64):
        link_length, coordinates = search_tolerances(hasty.certify, search_problem(machine, line))
    for tolerance in (link_length, coordinates):
        assert 0.0 < tolerance.eps_m < tolerance.refuted_m <= 1.3 * tolerance.eps_m
        assert tolerance.eps_m < tolerance.fails_m
        assert tolerance.chain is not None
        assert tolerance.chain.uncertainty.length_m == tolerance.eps_m
    assert coordinates.eps_m < link_length.eps_m


@pytest.mark.slow
def test_a_path_near_a_singularity_bears_little(
    hasty: Config, machine: Machine, line: Path, singular_at: float
) -> None:
    """The nearer it comes, the smaller the errors that it bears, proven and seen."""
    s = np.linspace(0.0, 1.0, 41)[:, None]
    path = pose_path(machine, START + 0.97 * singular_at * s * TOWARDS_SINGULARITY, RLL)
    with working_precision(64):
        problems = (build_problem(machine, one, 1e-4) for one in (path, line))
        near, far = (largest_tolerance(hasty.certify, problem, lengths) for problem in problems)
    assert near.eps_m < 0.2 * far.eps_m
    assert near.fails_m < far.fails_m
    assert near.eps_m < near.fails_m


def test_a_machine_that_fails_does_so_at_its_eps(machine: Machine, singular_at: float) -> None:
    """More draws find no larger eps, and the failure lies beyond a hundredth of it."""
    s = np.linspace(0.0, 1.0, 41)[:, None]
    path = pose_path(machine, START + 0.97 * singular_at * s * TOWARDS_SINGULARITY, RLL)
    few, more = (failing_eps(machine, path, lengths, samples) for samples in (0, 4))
    assert 1e-6 < more <= few < 0.05


@pytest.mark.parametrize("eps", [-1e-12, np.nan, np.inf])
@pytest.mark.parametrize("name", ["length_m", "coordinate_m"])
def test_an_uncertainty_is_a_number_that_is_not_negative(name: str, eps: float) -> None:
    """Anything else would count as certain."""
    with pytest.raises(ValueError, match="finite and not negative"):
        Uncertainty(**{name: eps})


def test_uncertainty_says_whether_there_is_any() -> None:
    """Of lengths, or of coordinates."""
    assert not Uncertainty().any
    assert Uncertainty(length_m=1e-6).any
    assert replace(Uncertainty(), coordinate_m=1e-6).any
