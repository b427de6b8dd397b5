"""Results of the stages as arrays in .npz files, and back: what is loaded is exactly what was saved."""

import contextlib
import io
import pathlib
import zipfile
from collections.abc import Iterator, Mapping
from dataclasses import asdict, fields
from typing import Any

import numpy as np
import numpy.typing as npt
from scipy.interpolate import BSpline, PPoly

from pipeline.errors import UsageError
from pipeline.export.columns import POSITIONS
from pipeline.machine.geometry import Machine
from pipeline.refine.result import Path, Refinement
from pipeline.retime.result import TimingReport, Trajectory
from pipeline.route.regions.build import RegionTable
from pipeline.route.result import Route, Search
from pipeline.status import Status

Arrays = Mapping[str, npt.NDArray[Any]]

CONTROLLED = ("x_m", "y_m", "z_m", "rx_rad", "rz_rad")
"""Columns of a controlled pose."""
Q_COLUMNS = POSITIONS
"""Columns of the actuator positions."""


def npz_bytes(arrays: Mapping[str, object]) -> bytes:
    """Write arrays as an .npz file: the same arrays always give the same bytes."""
    buffer = io.BytesIO()
    np.savez(buffer, allow_pickle=False, **{name: np.asarray(array) for name, array in arrays.items()})
    return buffer.getvalue()


def read_npz(path: pathlib.Path) -> dict[str, npt.NDArray[Any]]:
    """Read all arrays of an .npz file.

    Raises
    ------
    UsageError
        When it is not a readable one.
    """
    with readable(path), np.load(path, allow_pickle=False) as arrays:
        return dict(arrays)


@contextlib.contextmanager
def readable(path: pathlib.Path) -> Iterator[None]:
    """Say which file it is that cannot be made sense of."""
    try:
        yield
    except (KeyError, ValueError, TypeError, EOFError, zipfile.BadZipFile) as error:
        raise UsageError(
            f"{path} cannot be read ({error}): it may have been written by another version.\n"
            "  What to change: run the pipeline again with --force."
        ) from None


def pack_regions(table: RegionTable) -> dict[str, npt.NDArray[Any]]:
    """One array per column of the region table, each of shape (n,)."""
    return {
        **dict(zip(CONTROLLED, table.controlled.T, strict=True)),
        "ry_rad": table.ry_rad,
        "mode": table.modes,
        "gate": table.gates,
        **dict(zip(Q_COLUMNS, table.q_m.T, strict=True)),
        "kappa": table.kappa,
        "det_sign": table.det_sign,
        "link_distance_m": table.link_distance_m,
        "x_min_m": table.x_window_m[:, 0],
        "x_max_m": table.x_window_m[:, 1],
        "visit": table.visits,
    }


def unpack_regions(arrays: Arrays) -> RegionTable:
    """Rebuild the region table from its columns."""
    same_name = ("ry_rad", "kappa", "det_sign", "link_distance_m")
    return RegionTable(
        controlled=_stack(arrays, CONTROLLED),
        q_m=_stack(arrays, Q_COLUMNS),
        x_window_m=_stack(arrays, ("x_min_m", "x_max_m")),
        modes=arrays["mode"],
        gates=arrays["gate"],
        visits=arrays["visit"],
        **{name: arrays[name] for name in same_name},
    )


def pack_route(route: Route) -> dict[str, object]:
    """Arrays of the route, and how it was found as arrays of no dimension."""
    return {
        "region": route.region,
        "mode": route.modes,
        "gate": route.gates,
        "visit": route.visits,
        "pose": route.pose,
        "q_m": route.q_m,
        "kappa": route.kappa,
        "objective": route.objective,
        "status": str(route.status),
        **{f"search_{field.name}": getattr(route.search, field.name) for field in fields(Search)},
    }


def unpack_route(arrays: Arrays) -> Route:
    """Rebuild the route."""
    return Route(
        region=arrays["region"],
        modes=arrays["mode"],
        gates=arrays["gate"],
        visits=arrays["visit"],
        pose=arrays["pose"],
        q_m=arrays["q_m"],
        kappa=arrays["kappa"],
        objective=arrays["objective"].item(),
        status=Status(arrays["status"].item()),
        search=Search(**{field.name: arrays[f"search_{field.name}"].item() for field in fields(Search)}),
    )


def pack_refinement(refinement: Refinement) -> dict[str, object]:
    """Arrays of the refined path, those of the coarse one with the prefix `coarse_`, and how they were found."""
    return {
        **pack_path(refinement.path, ""),
        **pack_path(refinement.coarse, "coarse_"),
        "status": str(refinement.status),
        "iterations": refinement.iterations,
        "rounds": refinement.rounds,
        "meshes": refinement.meshes,
        "mesh_change": np.nan if refinement.mesh_change is None else refinement.mesh_change,
        "nodes": refinement.nodes,
        "surrogate_integral": refinement.surrogate_integral,
    }


def unpack_refinement(arrays: Arrays, machine: Machine) -> Refinement:
    """Rebuild both paths for the machine they were made for."""
    return Refinement(
        path=unpack_path(arrays, "", machine),
        coarse=unpack_path(arrays, "coarse_", machine),
        status=Status(arrays["status"].item()),
        iterations=arrays["iterations"].item(),
        rounds=arrays["rounds"].item(),
        meshes=arrays["meshes"].item(),
        mesh_change=None if np.isnan(arrays["mesh_change"]) else arrays["mesh_change"].item(),
        nodes=arrays["nodes"].item(),
        surrogate_integral=arrays["surrogate_integral"].item(),
    )


def pack_trajectory(trajectory: Trajectory) -> dict[str, object]:
    """Breakpoints (n + 1,) and coefficients (degree + 1, n) of the time law, highest power first, and how it was found.

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
    law = PPoly(arrays["coefficients"], arrays["t_s"])
    return Trajectory(path, law, (start, goal), TimingReport(**how) if how else None)


def pack_path(path: Path, prefix: str) -> dict[str, object]:
    """Arrays of a path, their names with a prefix."""
    return {
        f"{prefix}degree": path.spline.k,
        f"{prefix}knots": path.spline.t,
        f"{prefix}coefficients": path.spline.c,
        f"{prefix}node_s": path.node_s,
        f"{prefix}node_pose": path.node_pose,
    }


def unpack_path(arrays: Arrays, prefix: str, machine: Machine) -> Path:
    """Rebuild a path for the machine it was made for."""
    spline = BSpline(arrays[f"{prefix}knots"], arrays[f"{prefix}coefficients"], arrays[f"{prefix}degree"].item())
    return Path(machine, spline, arrays[f"{prefix}node_s"], arrays[f"{prefix}node_pose"])


def _stack(arrays: Arrays, names: tuple[str, ...]) -> npt.NDArray[Any]:
    return np.stack([arrays[name] for name in names], axis=1)
