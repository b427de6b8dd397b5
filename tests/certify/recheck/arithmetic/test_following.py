"""Errors of the actuators by other code: as tight as the search within a few percent, and never below it."""

from dataclasses import replace

import numpy as np
import pytest

from pipeline.certify.chain import Chain, close_chain
from pipeline.certify.problem import build_problem
from pipeline.certify.recheck.arithmetic.chain import evaluate_chain
from pipeline.certify.recheck.claims.chain import count_boxes
from pipeline.certify.result import ProvenChain, proven_chain
from pipeline.inclusion.closure import working_precision
from pipeline.inclusion.uncertainty import Uncertainty, of_actuators
from pipeline.machine import Machine
from pipeline.refine import Path

UNCERTAIN = (
    of_actuators(np.ones(5))(2e-3),
    of_actuators(np.array([1.0, 1.0, 1.0, 0.2, 0.2]))(4e-3),
    of_actuators(np.eye(5)[4])(8e-3),
    Uncertainty(1e-4, 2e-5, (1e-3,) * 5),
)


def _prove(path: Path, uncertainty: Uncertainty) -> Chain:
    with working_precision(64):
        chain = close_chain(build_problem(path.machine, path, 1e-4, uncertainty))
    assert chain.failure is None
    return chain


def _all_hold(path: Path, chain: ProvenChain) -> bool:
    return all(count_boxes(part).all_hold for part in evaluate_chain(path.machine, path, chain))


@pytest.mark.parametrize("uncertainty", UNCERTAIN)
def test_what_was_proven_is_verified_and_more_is_not(machine: Machine, line: Path, uncertainty: Uncertainty) -> None:
    """Images are those of the search or a little more; errors half as large again do not fit the same boxes."""
    chain = _prove(line, uncertainty)
    proven = proven_chain(chain, uncertainty)
    (segment,) = evaluate_chain(machine, line, proven)
    assert count_boxes(segment).all_hold
    found = np.array([[float(k.upper()) for k in one.image] for one in chain.inclusions]).T
    ratio = segment.inclusions.image / found
    assert ((ratio > 0.9999) & (ratio < 1.05)).all()
    more = replace(uncertainty, actuator_m=tuple(1.5 * error for error in uncertainty.actuator_m))
    assert not _all_hold(line, replace(proven, uncertainty=more))


def test_joints_that_are_moved_are_not_held(machine: Machine, line: Path) -> None:
    """By a tenth of a millimetre more than the box is wide."""
    uncertainty = UNCERTAIN[0]
    proven = proven_chain(_prove(line, uncertainty), uncertainty)
    first = proven.joints[0]
    moved = replace(first, pose=first.pose + np.eye(4)[:1].T * (proven.boxes[0].radius + 1e-4))
    assert not _all_hold(line, replace(proven, joints=(moved, *proven.joints[1:])))
