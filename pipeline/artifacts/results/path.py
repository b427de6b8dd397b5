"""Paths as files: those of a run (`path.npz`, `path.csv`), and a path by itself."""

import pathlib

import numpy as np
from scipy.interpolate import BSpline

from pipeline.artifacts.checked import CheckedArrays
from pipeline.artifacts.layout import PATH_CSV, PATH_NPZ
from pipeline.artifacts.npz import Arrays, npz_bytes, read_npz, readable
from pipeline.artifacts.output import write_output
from pipeline.artifacts.results.columns import Q_COLUMNS, split_columns
from pipeline.artifacts.results.saved import SavedRun
from pipeline.export.csv import format_csv
from pipeline.export.trajectory_columns import POSE
from pipeline.machine.geometry import Machine
from pipeline.machine.working_modes import mode_names, working_modes
from pipeline.refine.measure import PathSamples
from pipeline.refine.result import Path, Refinement
from pipeline.status import Status


def path_files(refinement: Refinement, samples: PathSamples) -> dict[str, bytes]:
    """Write both paths as splines, and dense samples of the refined one."""
    columns = {
        "s": samples.s,
        **split_columns(POSE, samples.pose),
        "kappa": samples.kappa,
        **split_columns(Q_COLUMNS, samples.q_m),
        "mode": np.array(mode_names(working_modes(samples.reach_m))),
    }
    return {PATH_NPZ: npz_bytes(pack_refinement(refinement)), PATH_CSV: format_csv(columns).encode()}


def load_refinement(run: SavedRun) -> Refinement:
    """Load both paths of a run."""
    file = run.folder / PATH_NPZ
    with readable(file):
        return unpack_refinement(read_npz(file), run.machine)


def save_path(file: pathlib.Path | str, path: Path) -> None:
    """Write degree, knots, coefficients and node poses of a path as an .npz file."""
    write_output(pathlib.Path(file), npz_bytes(pack_path(path, "")))


def load_path(file: pathlib.Path | str, machine: Machine) -> Path:
    """Load a path for the machine it was made for: what `save_path` wrote, or the `path.npz` of a run.

    Raises
    ------
    UsageError
        When the file cannot be read as a path.
    """
    file = pathlib.Path(file)
    with readable(file):
        return unpack_path(read_npz(file), "", machine)


def pack_refinement(refinement: Refinement) -> dict[str, object]:
    """Give the arrays of the refined path, of the coarse one with the prefix `coarse_`, and how they were found."""
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
    """Rebuild both paths for the machine they were made for.

    Raises
    ------
    ValueError
        When an array is missing, or is not one of a refinement.
    """
    checked = CheckedArrays(arrays)
    change = checked.number("mesh_change")
    return Refinement(
        path=unpack_path(arrays, "", machine),
        coarse=unpack_path(arrays, "coarse_", machine),
        status=Status(checked.text("status")),
        iterations=checked.count("iterations"),
        rounds=checked.count("rounds"),
        meshes=checked.count("meshes"),
        mesh_change=None if np.isnan(change) else change,
        nodes=checked.count("nodes"),
        surrogate_integral=checked.number("surrogate_integral"),
    )


def pack_path(path: Path, prefix: str) -> dict[str, object]:
    """Give the arrays of a path under names with a prefix."""
    return {
        f"{prefix}degree": path.spline.k,
        f"{prefix}knots": path.spline.t,
        f"{prefix}coefficients": path.spline.c,
        f"{prefix}node_s": path.node_s,
        f"{prefix}node_pose": path.node_pose,
        **({} if path.motion_s is None else {f"{prefix}motion_s": path.motion_s}),
    }


def unpack_path(arrays: Arrays, prefix: str, machine: Machine) -> Path:
    """Rebuild a path for the machine it was made for.

    Raises
    ------
    ValueError
        When an array is missing, or they are not those of a path over s from 0 to 1.
    """
    checked = CheckedArrays(arrays)
    degree = checked.count(f"{prefix}degree")
    knots, coefficients = checked.floats(f"{prefix}knots", "k"), checked.floats(f"{prefix}coefficients", "c", 5)
    if len(knots) != len(coefficients) + degree + 1:
        raise ValueError(f"{len(knots)} knots and {len(coefficients)} coefficients are no splines of degree {degree}")
    node_s, node_pose = checked.floats(f"{prefix}node_s", "m"), checked.floats(f"{prefix}node_pose", "m", 6)
    spline = BSpline(knots, coefficients, degree)
    if (spline.t[degree], spline.t[-degree - 1]) != (0.0, 1.0):
        raise ValueError(f"{prefix}knots are not those of s from 0 to 1")
    motion_s = checked.number(f"{prefix}motion_s") if f"{prefix}motion_s" in checked else None
    return Path(machine, spline, node_s, node_pose, motion_s=motion_s)
