"""Tests of the re-check: true proofs hold, forged ones do not."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from pipeline.arrays import IntArray
from pipeline.bound.bound import bound_paths
from pipeline.bound.recheck.verify import verify_bound
from pipeline.bound.tree import EXCLUDED, OPEN, proof_codes
from pipeline.config import Config
from pipeline.machine.geometry import build_machine
from pipeline.route.regions.endpoints import task_endpoints

KAPPA = 50.0


@pytest.fixture(scope="module")
def proof(quick_config: Config, vary: Callable[..., Config]) -> tuple[tuple[Any, ...], IntArray]:
    """Prove that kappa exceeds 50 on every path without tilt: the task, and the codes of the tree."""
    config = vary(quick_config, {"task.locked_axes": ["rx", "rz"]})
    machine = build_machine(config.machine)
    task = config, machine, task_endpoints(config, machine)
    found = bound_paths(*task, kappa=KAPPA, most_boxes=60_000)
    assert found.flood is not None
    return task, proof_codes(found.flood)


def test_a_proof_holds(proof: tuple[tuple[Any, ...], IntArray]):
    """Every box of the wall is verified by other code in another frame."""
    task, codes = proof
    found = verify_bound(*task, KAPPA, codes)
    assert found.holds
    assert found.wall > 400


def test_a_larger_claim_does_not_hold(proof: tuple[tuple[Any, ...], IntArray]):
    """The same tree does not prove more than it was made for."""
    task, codes = proof
    found = verify_bound(*task, 10.0 * KAPPA, codes)
    assert found.separated
    assert found.refuted > 0


def test_a_hole_in_the_wall_is_found(proof: tuple[tuple[Any, ...], IntArray]):
    """Claiming less of the wall joins start and goal, or leaves other boxes to be verified."""
    task, codes = proof
    holes = np.where(codes == EXCLUDED, OPEN, codes)
    assert not verify_bound(*task, KAPPA, holes).separated


def test_boxes_that_hold_poses_are_not_believed(proof: tuple[tuple[Any, ...], IntArray]):
    """A tree that excludes everything, or all around the start, is refused."""
    task, codes = proof
    for forged in (np.array([EXCLUDED]), np.where(codes == OPEN, EXCLUDED, codes)):
        assert verify_bound(*task, KAPPA, forged).refuted > 0
