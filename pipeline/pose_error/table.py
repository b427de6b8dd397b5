"""A proven error of the tool as columns, and back."""

from collections.abc import Mapping
from typing import Any

import numpy as np
import numpy.typing as npt

from pipeline.arrays import FloatArray
from pipeline.export.csv import DECIMALS
from pipeline.inclusion.uncertainty import Uncertainty
from pipeline.machine.geometry import ACTUATORS
from pipeline.pose_error.amplification import DriveAmplification
from pipeline.pose_error.bound import PoseError

INTERVAL_COLUMNS = ("s_first", "s_last")
"""Where a row begins and ends."""
_OF_INTERVALS = (*INTERVAL_COLUMNS, "position_m", "rotation_rad")
_POSITIONS = tuple(f"amplification_{name}" for name in ACTUATORS)
_ROTATIONS = tuple(f"rotation_{name}_radpm" for name in ACTUATORS)


def pose_error_columns(found: PoseError) -> dict[str, FloatArray]:
    """Name the columns: a row per interval of s, with the bounds and how the tool moves and turns with each drive."""
    # Bounds are rounded up to what the table has of them.
    bounds = (np.ceil(values * 10.0**DECIMALS) / 10.0**DECIMALS for values in (found.position_m, found.rotation_rad))
    known = (found.edges[:-1], found.edges[1:], *bounds)
    return {
        **dict(zip(_OF_INTERVALS, known, strict=True)),
        **dict(zip(_POSITIONS, found.amplification.position.T, strict=True)),
        **dict(zip(_ROTATIONS, found.amplification.rotation_radpm.T, strict=True)),
    }


def pose_error_of(uncertainty: Uncertainty, columns: Mapping[str, npt.NDArray[Any]]) -> PoseError:
    """Take the bounds for an uncertainty from columns.

    Raises
    ------
    KeyError
        If a column is missing.
    """

    def stacked(names: tuple[str, ...]) -> FloatArray:
        return np.stack([np.asarray(columns[name], dtype=float) for name in names], axis=1)

    first, last, position, angle = stacked(_OF_INTERVALS).T
    amplified = DriveAmplification(stacked(_POSITIONS), stacked(_ROTATIONS))
    return PoseError(uncertainty, np.append(first, last[-1:]), position, angle, amplified)
