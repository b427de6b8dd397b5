"""The stated error of the tool is verified by other arithmetic, and nothing beyond it is."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from pipeline.artifacts.results.pose_error import amplification_claim
from pipeline.certify.recheck.pose_error import ERRORS, POSITION, ROTATION, StatedError, verify_pose_error
from pipeline.certify.result import ProvenChain
from pipeline.inclusion.uncertainty import Uncertainty
from pipeline.machine import Machine
from pipeline.pose_error import PoseError, bound_pose_error, sample_pose_error
from pipeline.refine import Path
from tests.certify.paths import pose_path
from tests.pose_error.conftest import DRIVES, EVERYTHING


def _stated(found: PoseError) -> StatedError:
    assert found.chain is not None
    intervals = np.column_stack([found.edges[:-1], found.edges[1:]])
    return StatedError(found.chain, intervals, found.position_m, found.rotation_rad)


def _refused(path: Path, stated: StatedError, asked: Uncertainty = DRIVES) -> set[str]:
    claims = verify_pose_error(path.machine, path, stated, asked)
    return {claim.what.removeprefix("tool: ") for claim in claims if not claim.verified}


def test_what_was_proven_is_verified(line: Path, of_drives: PoseError, of_everything: PoseError) -> None:
    """Of drives alone, and of drives and geometry."""
    assert _refused(line, _stated(of_drives)) == set()
    assert _refused(line, _stated(of_everything), EVERYTHING) == set()


def test_a_platform_that_is_tilted_far_is_verified(machine: Machine) -> None:
    """With the axes of rx and ry nearly along each other."""
    begins = np.array([1.02, 0.3, 0.9, 0.3, 1.35])
    path = pose_path(machine, np.linspace(begins - 0.001, begins + 0.001, 7), 0, 7)
    found = bound_pose_error(path, DRIVES)
    assert _refused(path, _stated(found)) == set()
    s = found.middles[::16]
    assert (sample_pose_error(path, DRIVES, s).rotation_rad <= found.rotation_rad[::16]).all()


@pytest.mark.parametrize("name", ["position_m", "rotation_rad"])
def test_smaller_errors_are_refused(line: Path, of_drives: PoseError, name: str) -> None:
    """By a hundredth in a single interval."""
    values = getattr(of_drives, name).copy()
    values[len(values) // 2] *= 0.99
    forged = replace(_stated(of_drives), **{name: values})
    assert _refused(line, forged) == {POSITION if name == "position_m" else ROTATION}


def test_the_row_with_a_smaller_error_is_named(line: Path, of_drives: PoseError) -> None:
    """With its interval and both figures, even where the largest of the table is another one."""
    values = of_drives.position_m.copy()
    row = int(values.argmin())
    values[row] *= 0.9
    stated = replace(_stated(of_drives), position_m=values)
    (claim,) = (one for one in verify_pose_error(line.machine, line, stated, DRIVES) if not one.verified)
    assert claim.found.startswith(f"row {row + 1}, s = {of_drives.edges[row]:.6g} to ")
    assert f"stated {1e3 * values[row]:.6g} mm (1 of {len(values)} rows)" in claim.found


def test_amplifications_of_the_table_are_computed_again(line: Path, of_drives: PoseError) -> None:
    """One that is a thousandth off is refused, and named by its row."""
    assert of_drives.chain is not None
    assert amplification_claim(line, of_drives.chain, of_drives).verified
    forged = of_drives.amplification.rotation_radpm.copy()
    forged[3, 1] *= 1.001
    gains = replace(of_drives.amplification, rotation_radpm=forged)
    claim = amplification_claim(line, of_drives.chain, replace(of_drives, amplification=gains))
    assert not claim.verified
    assert claim.found.startswith("row 4, c2: ")
    fewer = replace(gains, position=gains.position[1:], rotation_radpm=forged[1:])
    assert not amplification_claim(line, of_drives.chain, replace(of_drives, amplification=fewer)).verified


def _larger(chain: ProvenChain) -> ProvenChain:
    """Say that the boxes are of drives that are off ten times as far."""
    return replace(chain, uncertainty=Uncertainty(actuator_m=(1e-3,) * 5))


def _gap(chain: ProvenChain) -> ProvenChain:
    return replace(chain, boxes=chain.boxes[:-1], joints=chain.joints[:-1])


def _elsewhere(chain: ProvenChain) -> ProvenChain:
    """Move every box by more than it is wide."""
    boxes = [replace(box, pose=box.pose + np.eye(4)[:, :1] * np.full(6, 0.01)) for box in chain.boxes]
    return replace(chain, boxes=tuple(boxes))


@pytest.mark.parametrize(
    ("change", "wrong"),
    [(_larger, ERRORS), (_gap, "boxes cover s = 0 to 1"), (_elsewhere, "each box holds one regular pose")],
)
def test_other_chains_are_refused(
    line: Path, of_drives: PoseError, change: Callable[[ProvenChain], ProvenChain], wrong: str
) -> None:
    """Of other errors, of a part of the path, of other poses."""
    stated = _stated(of_drives)
    forged = replace(stated, chain=change(stated.chain))
    assert wrong in _refused(line, forged)


def test_boxes_of_smaller_errors_do_not_hold_larger_ones(line: Path, of_drives: PoseError) -> None:
    """The arithmetic finds it, not the comparison of the errors."""
    stated = _stated(of_drives)
    wrong = _refused(line, replace(stated, chain=_larger(stated.chain)), Uncertainty(actuator_m=(1e-3,) * 5))
    assert ERRORS not in wrong
    assert {"each box holds one regular pose", POSITION, ROTATION} <= wrong
