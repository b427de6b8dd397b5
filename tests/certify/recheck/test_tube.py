"""The tube about the path that the chains of a certificate have."""

import numpy as np
import pytest

from pipeline.certify.recheck.tube import ProvenTube, proven_tubes
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
    assert proven_tubes(_chains(*errors)) == ()


def test_the_widest_is_taken() -> None:
    """Every chain is a proof."""
    (tube,) = proven_tubes(_chains(ALIKE(1e-3), ALIKE(2e-3), of_actuators(np.eye(5)[0])(1e-2)))
    assert tube.errors_m.tolist() == [2e-3] * 5
    assert not tube.within_limits


@pytest.mark.parametrize(
    ("within_limits", "kept", "lost"), [(True, "are kept", "may be"), (False, "may be", "nothing")]
)
def test_it_says_what_is_proven_and_what_no_longer_is(within_limits: bool, kept: str, lost: str) -> None:
    """Inside and outside."""
    tube = ProvenTube(np.full(5, 1e-3), within_limits)
    assert tube.meaning.startswith("no singularity is met")
    assert kept in tube.meaning
    assert lost in tube.lost
