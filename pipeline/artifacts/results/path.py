"""Paths as files: those of a run (`path.npz`, `path.csv`), and a path by itself."""

import pathlib

import numpy as np
from scipy.interpolate import BSpline

from pipeline.arguments import require_array, require_whole
from pipeline.artifacts.files import write_whole
from pipeline.artifacts.layout import PATH_CSV, PATH_NPZ
from pipeline.artifacts.npz import Arrays, npz_bytes, read_npz, readable
from pipeline.artifacts.results.columns import Q_COLUMNS, split_columns
from pipeline.artifacts.results.saved import SavedRun
from pipeline.export.csv import format_csv
from pipeline.export.trajectory_columns import POSE
from pipeline.machine.geometry import Machine
from pipeline.machine.working_modes import mode_names, working_modes
from pipeline.refine.measure import PathSamples
from pipeline.refine.result import MOST_DEGREE, Path, Refinement
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
    write_whole(pathlib.Path(file), npz_bytes(pack_path(path, "")))


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


def pack_path(path: Path, prefix: str) -> dict[str, object]:
    """Give the arrays of a path under names with a prefix."""
    return {
        f"{prefix}degree": path.spline.k,
        f"{prefix}knots": path.spline.t,
        f"{prefix}coefficients": path.spline.c,
        f"{prefix}node_s": path.node_s,
        f"{prefix}node_pose": path.node_pose,
    }


def unpack_path(arrays: Arrays, prefix: str, machine: Machine) -> Path:
    """Rebuild a path for the machine it was made for.

    Raises
    ------
    KeyError, ArgumentError
        When an array is missing, or not one of real numbers, which `BSpline` would make of it.
    """
    knots, coefficients, node_s, node_pose = (
        require_array(f"{prefix}{name}", arrays[f"{prefix}{name}"], shape)
        for name, shape in (
            ("knots", ("n",)),
            ("coefficients", ("n", 5)),
            ("node_s", ("k",)),
            ("node_pose", ("k", 6)),
        )
    )
    degree = require_whole(f"{prefix}degree", arrays[f"{prefix}degree"], 0, MOST_DEGREE)
    return Path(machine, BSpline(knots, coefficients, degree), node_s, node_pose)
