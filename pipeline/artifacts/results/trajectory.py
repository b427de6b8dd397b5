"""The trajectory as files: `trajectory.npz` to load it back, tables with their sidecars for controllers."""

from collections.abc import Callable, Mapping
from dataclasses import asdict, fields
from typing import Any, get_type_hints

import numpy as np
from scipy.interpolate import PPoly

from pipeline.artifacts.checked import CheckedArrays
from pipeline.artifacts.files import json_bytes
from pipeline.artifacts.layout import BACK_CSV, BACK_JSON, TRAJECTORY_CSV, TRAJECTORY_JSON, TRAJECTORY_NPZ
from pipeline.artifacts.npz import Arrays, npz_bytes, read_npz, readable
from pipeline.artifacts.results.path import load_refinement
from pipeline.artifacts.results.saved import SavedRun
from pipeline.export.csv import DECIMALS, format_csv
from pipeline.export.request import needed_decimals
from pipeline.export.trajectory_columns import trajectory_columns
from pipeline.machine.geometry import Machine
from pipeline.refine.result import Path
from pipeline.retime.result import TimingReport, Trajectory, TrajectorySamples

_MOST_COEFFICIENTS = 10
_ROUNDING = 1e-6


def trajectory_files(
    trajectory: Trajectory, samples: TrajectorySamples, sidecar: Mapping[str, Any]
) -> dict[str, bytes]:
    """Write the trajectory: samples for controllers, the meaning of their columns, and everything to load it back."""
    return {
        TRAJECTORY_NPZ: npz_bytes(pack_trajectory(trajectory)),
        TRAJECTORY_CSV: _trajectory_csv(trajectory.path.machine, samples),
        TRAJECTORY_JSON: json_bytes(sidecar),
    }


def back_files(machine: Machine, samples: TrajectorySamples, sidecar: Mapping[str, Any]) -> dict[str, bytes]:
    """Write the trajectory of the way back: samples for controllers, and the meaning of their columns."""
    return {BACK_CSV: _trajectory_csv(machine, samples), BACK_JSON: json_bytes(sidecar)}


def load_trajectory(run: SavedRun) -> Trajectory:
    """Load the trajectory of a run, along its refined path."""
    file = run.folder / TRAJECTORY_NPZ
    path = load_refinement(run).path
    with readable(file):
        return unpack_trajectory(read_npz(file), path)


def pack_trajectory(trajectory: Trajectory) -> dict[str, object]:
    """Give breakpoints (n + 1,) and coefficients (degree + 1, n) of the time law, highest power first, and its quality.

    The path it runs along is saved with the refinement.
    """
    report = {} if trajectory.timing is None else asdict(trajectory.timing)
    how = {f"quality_{name}": value for name, value in report.items()}
    time_law = trajectory.time_law
    return {"t_s": time_law.x, "coefficients": time_law.c, "dwell_s": trajectory.dwell_s, **how}


def unpack_trajectory(arrays: Arrays, path: Path) -> Trajectory:
    """Rebuild the time law along its path.

    Raises
    ------
    ValueError
        When an array is missing, or they are not those of a time law.
    """
    checked = CheckedArrays(arrays)
    start, goal = checked.floats("dwell_s", 2).tolist()
    t_s = checked.floats("t_s", "t")
    if len(t_s) < 2 or (np.diff(t_s) <= 0.0).any() or min(start, goal) < 0.0:
        raise ValueError("time does not increase from each of t_s to the next, or something waits less than no time")
    coefficients = checked.floats("coefficients", "d", len(t_s) - 1)
    if not 1 <= len(coefficients) <= _MOST_COEFFICIENTS:
        raise ValueError(f"coefficients has the shape {coefficients.shape}")
    time_law = PPoly(coefficients, t_s)
    if not np.allclose(time_law(t_s[[0, -1]]), [0.0, 1.0], rtol=0.0, atol=_ROUNDING):
        raise ValueError("s does not run from 0 to 1")
    return Trajectory(path, time_law, (start, goal), _timing(checked))


def _timing(checked: CheckedArrays) -> TimingReport | None:
    if not any(f"quality_{field.name}" in checked for field in fields(TimingReport)):
        return None
    read: dict[type, Callable[[str], Any]] = {bool: checked.flag, int: checked.count, float: checked.number}
    return TimingReport(**{name: read[kind](f"quality_{name}") for name, kind in get_type_hints(TimingReport).items()})


def _trajectory_csv(machine: Machine, samples: TrajectorySamples) -> bytes:
    decimals = max(DECIMALS, needed_decimals(samples.period_s, machine.acceleration_mps2))
    return format_csv(trajectory_columns(samples), decimals).encode()
