"""Claims of chains whose actuators are off: limits and reserves hold for all errors, or are refused."""

import numpy as np
import pytest

from pipeline.certify.recheck.claims.errors import limit_claim, reserve_claims
from pipeline.config import Config
from pipeline.machine import Machine
from pipeline.machine.clearance import link_pairs


def _evidence(
    machine: Machine, kappa: float, signs: tuple[float, float], least_m: float
) -> tuple[np.ndarray, np.ndarray]:
    distances = np.full(len(link_pairs(machine)), 0.5)
    distances[3] = least_m
    found = np.array([[-np.inf, kappa], signs])
    return found, np.column_stack([distances, np.full(len(distances), np.inf)])


@pytest.mark.parametrize(
    ("kappa", "signs", "least_m", "kept"),
    [
        (100.0, (1.0, 1.0), 0.03, True),
        (100.1, (1.0, 1.0), 0.03, False),
        (np.nan, (1.0, 1.0), 0.03, False),
        (50.0, (-1.0, 1.0), 0.03, False),
        (50.0, (0.0, 0.0), 0.03, False),
        (50.0, (-1.0, -1.0), 0.0299, False),
        (50.0, (-1.0, -1.0), np.nan, False),
    ],
)
def test_every_limit_counts(
    agder_config: Config, machine: Machine, kappa: float, signs: tuple[float, float], least_m: float, kept: bool
) -> None:
    """Kappa up to its cap, det H of one sign, and every pair as far apart as is required."""
    claim = limit_claim("chain", agder_config, machine, _evidence(machine, kappa, signs, least_m))
    assert claim.verified == kept


def test_a_reserve_is_not_below_what_is_found() -> None:
    """Of either tilt; where none is stated, nothing is claimed."""
    found = np.array([0.5, 0.7])
    assert [claim.verified for claim in reserve_claims("chain", found, (0.5, 0.7))] == [True]
    assert [claim.verified for claim in reserve_claims("chain", found, (0.6, 0.69))] == [False]
    assert list(reserve_claims("chain", found, None)) == []
