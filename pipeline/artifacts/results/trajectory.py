"""The trajectory as files: `trajectory.npz` to load it back, tables with their sidecars for controllers."""

from collections.abc import Mapping
from dataclasses import asdict
from typing import Any

from scipy.interpolate import PPoly

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
    """Rebuild the time law along its path."""
    how = {name.removeprefix("quality_"): array.item() for name, array in arrays.items() if name.startswith("quality_")}
    start, goal = arrays["dwell_s"].tolist()
    time_law = PPoly(arrays["coefficients"], arrays["t_s"])
    return Trajectory(path, time_law, (start, goal), TimingReport(**how) if how else None)


def _trajectory_csv(machine: Machine, samples: TrajectorySamples) -> bytes:
    decimals = max(DECIMALS, needed_decimals(samples.period_s, machine.acceleration_mps2))
    return format_csv(trajectory_columns(samples), decimals).encode()
