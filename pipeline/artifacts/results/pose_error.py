"""The proven error of the tool as files: a table, and the boxes with which it can be verified again."""

import pathlib
from collections.abc import Sequence

import numpy as np

from pipeline.arrays import FloatArray
from pipeline.artifacts.files import naming
from pipeline.artifacts.layout import POSE_ERROR_CSV, POSE_ERROR_NPZ
from pipeline.artifacts.npz import npz_bytes, read_npz, readable
from pipeline.artifacts.results.saved import SavedRun
from pipeline.certify.recheck import Claim
from pipeline.certify.recheck.pose_error import StatedError
from pipeline.certify.result import ProvenChain
from pipeline.config.stages.pose_error import PoseErrorConfig
from pipeline.export.csv import format_csv, read_csv
from pipeline.inclusion.krawczyk import Box
from pipeline.inclusion.uncertainty import Uncertainty
from pipeline.machine.geometry import ACTUATORS
from pipeline.pose_error import PoseError, amplify_drives, pose_error_columns, pose_error_of
from pipeline.pose_error.table import INTERVAL_COLUMNS
from pipeline.refine.result import Path

AMPLIFICATIONS = "tool: pose_error.csv has the amplifications of each drive"
_VERSION = 1
_SAME = 1e-6
"""How far an amplification may be from the one computed again, relative and absolute."""


def pose_error_files(found: PoseError) -> dict[str, bytes]:
    """Write the bounds over s, and their boxes if they are known."""
    files = {POSE_ERROR_CSV: format_csv(pose_error_columns(found)).encode()}
    return files if found.chain is None else {**files, POSE_ERROR_NPZ: npz_bytes(_packed(found.chain))}


def uncertainty_of(config: PoseErrorConfig) -> Uncertainty:
    """Give the errors that the configuration has."""
    return Uncertainty(config.lengths_m, config.coordinates_m, config.drives_m)


def load_pose_error(run: SavedRun) -> PoseError | None:
    """Load the bounds of a run, without their boxes; None if its configuration asks for none.

    Raises
    ------
    UsageError
        When the file is damaged.
    """
    config = run.config.certify.pose_error
    return None if config is None else _read_table(run.folder, uncertainty_of(config))


def stated_error(folder: pathlib.Path) -> StatedError:
    """Read the boxes of a run, and what its table states over them.

    Raises
    ------
    UsageError
        When a file is damaged.
    OSError
        When there is none.
    """
    file = folder / POSE_ERROR_NPZ
    arrays = read_npz(file)
    with readable(file):
        if int(arrays["version"]) != _VERSION:
            raise ValueError(f"version {int(arrays['version'])}")
        length, coordinate, *drives = (float(error) for error in arrays["errors_m"])
        s = np.asarray(arrays["s"], dtype=float)
        boxes = _boxes(s[:-1], s[1:], (arrays["pose"], arrays["radius"]))
        joints = _boxes(s, s, (arrays["joint_pose"], arrays["joint_radius"]))
        if not boxes:
            raise ValueError("it has no boxes")
        chain = ProvenChain(Uncertainty(length, coordinate, tuple(drives)), boxes, joints)
    file = folder / POSE_ERROR_CSV
    with naming(file), readable(file):
        columns = read_csv(file.read_text())
        table = pose_error_of(chain.uncertainty, columns)
        intervals = np.stack([np.asarray(columns[name], dtype=float) for name in INTERVAL_COLUMNS], axis=1)
    return StatedError(chain, intervals, table.position_m, table.rotation_rad)


def amplification_claim(path: Path, chain: ProvenChain, found: PoseError) -> Claim:
    """Verify that a table's amplifications, which are computed and not proven, are those of the path over its boxes."""
    s = np.clip([chain.boxes[0].first, *(box.last for box in chain.boxes)], 0.0, 1.0)
    computed, stated = amplify_drives(path, s), found.amplification
    for of_table, wanted in ((stated.position, computed.position), (stated.rotation_radpm, computed.rotation_radpm)):
        if of_table.shape != wanted.shape:
            return Claim(AMPLIFICATIONS, verified=False, found=f"{len(of_table)} rows for {len(wanted)} boxes")
        same = np.isclose(of_table, wanted, rtol=_SAME, atol=_SAME)
        if not same.all():
            row, drive = np.argwhere(~same)[0].tolist()
            text = f"row {row + 1}, {ACTUATORS[drive]}: {of_table[row, drive]:.6g}; computed {wanted[row, drive]:.6g}"
            return Claim(AMPLIFICATIONS, verified=False, found=text)
    return Claim(AMPLIFICATIONS, verified=True, found=f"{len(stated.position)} rows, computed again")


def _read_table(folder: pathlib.Path, errors: Uncertainty) -> PoseError:
    file = folder / POSE_ERROR_CSV
    with naming(file), readable(file):
        return pose_error_of(errors, read_csv(file.read_text()))


def _packed(chain: ProvenChain) -> dict[str, object]:
    errors = chain.uncertainty
    return {
        "version": _VERSION,
        "errors_m": np.array([errors.length_m, errors.coordinate_m, *errors.actuator_m]),
        "s": np.array([chain.boxes[0].first, *(box.last for box in chain.boxes)]),
        "pose": _stacked(chain.boxes, "pose"),
        "radius": _stacked(chain.boxes, "radius"),
        "joint_pose": _stacked(chain.joints, "pose"),
        "joint_radius": _stacked(chain.joints, "radius"),
    }


def _stacked(boxes: Sequence[Box], name: str) -> FloatArray:
    return np.stack([getattr(box, name) for box in boxes])


def _boxes(first: FloatArray, last: FloatArray, arrays: tuple[FloatArray, FloatArray]) -> tuple[Box, ...]:
    pose, radius = (np.asarray(array, dtype=float) for array in arrays)
    if pose.shape != (len(first), 4, 6) or radius.shape != (len(first), 6):
        raise ValueError("its boxes have other shapes")
    if not all(np.isfinite(values).all() for values in (first, last, pose, radius)):
        raise ValueError("its boxes have numbers that are not finite")
    rows = zip(first.tolist(), last.tolist(), pose, radius, strict=True)
    return tuple(Box(begin, end, x, r) for begin, end, x, r in rows)
