"""The tube about the path that the chains of a certificate have."""

import numpy as np
import pytest

from pipeline.certify.recheck.tube import proven_tube
from pipeline.certify.result import ProvenChain
from pipeline.inclusion.uncertainty import CERTAIN, Uncertainty, of_actuators, of_lengths

ALIKE = of_actuators(np.ones(5))


def _chains(*errors: Uncertainty) -> list[ProvenChain]:
    return [ProvenChain(one, (), ()) for one in (CERTAIN, *errors)]


@pytest.mark.parametrize(
    "errors",
    [(), (of_lengths(1e-3),), (of_actuators(np.eye(5)[0])(1e-2), of_actuators(np.array([5, 5, 5, 1, 1]))(1e-3))],
)
def test_without_all_actuators_off_alike_there_is_none(errors: tuple[Uncertainty, ...]) -> None:
    """One that is off by itself says nothing about all of them, and neither does the calibration."""
    assert proven_tube(_chains(*errors)) is None


def test_the_widest_is_taken() -> None:
    """Every chain is a proof."""
    tube = proven_tube(_chains(ALIKE(1e-3), ALIKE(2e-3), of_actuators(np.eye(5)[0])(1e-2)))
    assert tube is not None
    assert tube.errors_m.tolist() == [2e-3] * 5
    assert not tube.within_limits
    assert tube.meaning == "no singularity is met, limits may be broken"
