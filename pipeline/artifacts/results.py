"""The files of each stage's result: what is written, and how it is loaded back."""

import io
import pathlib
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from pipeline.artifacts.files import json_bytes
from pipeline.artifacts.layout import (
    BACK_CSV,
    BACK_JSON,
    CERTIFICATE_JSON,
    PATH_CSV,
    PATH_NPZ,
    REGIONS_NPZ,
    ROUTE_CSV,
    ROUTE_NPZ,
    TRAJECTORY_CSV,
    TRAJECTORY_JSON,
    TRAJECTORY_NPZ,
    failure_names,
    failure_picture,
    figure_names,
)
from pipeline.artifacts.pack import (
    Q_COLUMNS,
    npz_bytes,
    pack_refinement,
    pack_regions,
    pack_route,
    pack_trajectory,
    read_npz,
    readable,
    unpack_refinement,
    unpack_regions,
    unpack_route,
    unpack_trajectory,
)
from pipeline.export.columns import POSE, trajectory_columns
from pipeline.export.csv import DECIMALS, format_csv
from pipeline.export.request import needed_decimals
from pipeline.machine.geometry import Machine
from pipeline.machine.working_modes import mode_names, working_modes
from pipeline.refine.measure import PathSamples
from pipeline.refine.result import Path, Refinement
from pipeline.retime.result import Trajectory, TrajectorySamples
from pipeline.route.regions.build import RegionTable
from pipeline.route.result import Route
from pipeline.stage import Stage

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from pipeline.certify.recheck import Statement
    from pipeline.certify.result import Certificate

Files = dict[str, bytes]


def regions_files(table: RegionTable) -> Files:
    """Write the region table."""
    return {REGIONS_NPZ: npz_bytes(pack_regions(table))}


def load_regions(folder: pathlib.Path) -> RegionTable:
    """Load the region table of a run."""
    with readable(folder / REGIONS_NPZ):
        return unpack_regions(read_npz(folder / REGIONS_NPZ))


def route_files(route: Route) -> Files:
    """Write the route: a row per step for people and programs, and everything to load it back."""
    columns = {
        "step": np.arange(len(route)),
        "region": route.region,
        "mode": np.array(route.mode_names),
        **_columns(POSE, route.pose),
        "kappa": route.kappa,
        **_columns(Q_COLUMNS, route.q_m),
        "gate": route.gates,
    }
    return {ROUTE_NPZ: npz_bytes(pack_route(route)), ROUTE_CSV: _csv(columns)}


def load_route(folder: pathlib.Path) -> Route:
    """Load the route of a run."""
    with readable(folder / ROUTE_NPZ):
        return unpack_route(read_npz(folder / ROUTE_NPZ))


def path_files(refinement: Refinement, samples: PathSamples) -> Files:
    """Write both paths as splines, and dense samples of the refined one."""
    columns = {
        "s": samples.s,
        **_columns(POSE, samples.pose),
        "kappa": samples.kappa,
        **_columns(Q_COLUMNS, samples.q_m),
        "mode": np.array(mode_names(working_modes(samples.reach_m))),
    }
    return {PATH_NPZ: npz_bytes(pack_refinement(refinement)), PATH_CSV: _csv(columns)}


def load_refinement(folder: pathlib.Path, machine: Machine) -> Refinement:
    """Load both paths of a run, for the machine they were made for."""
    with readable(folder / PATH_NPZ):
        return unpack_refinement(read_npz(folder / PATH_NPZ), machine)


def certificate_files(certificate: "Certificate", facts: Mapping[str, Any]) -> Files:
    """Write the certificate: its verdict and bounds, and the boxes with which it can be verified again."""
    from pipeline.artifacts.certificate import certificate_bytes

    return {CERTIFICATE_JSON: certificate_bytes(certificate, facts)}


def load_certificate(folder: pathlib.Path) -> "Statement":
    """Load what can be verified of the certificate of a run."""
    from pipeline.artifacts.certificate import read_certificate

    return read_certificate(folder / CERTIFICATE_JSON)


def trajectory_files(trajectory: Trajectory, samples: TrajectorySamples, sidecar: Mapping[str, Any]) -> Files:
    """Write the trajectory: sampled for controllers, what its columns mean, and everything to load it back."""
    return {
        TRAJECTORY_NPZ: npz_bytes(pack_trajectory(trajectory)),
        TRAJECTORY_CSV: _trajectory_csv(trajectory.path.machine, samples),
        TRAJECTORY_JSON: json_bytes(sidecar),
    }


def back_files(machine: Machine, samples: TrajectorySamples, sidecar: Mapping[str, Any]) -> Files:
    """Write the trajectory of the way back: sampled for controllers, and what its columns mean."""
    return {BACK_CSV: _trajectory_csv(machine, samples), BACK_JSON: json_bytes(sidecar)}


def load_trajectory(folder: pathlib.Path, path: Path) -> Trajectory:
    """Load the trajectory of a run, along the path it was made for."""
    with readable(folder / TRAJECTORY_NPZ):
        return unpack_trajectory(read_npz(folder / TRAJECTORY_NPZ), path)


def figure_files(figures: Mapping[str, "Figure"]) -> Files:
    """Write every figure under its own name, as pixels and as vectors."""
    files = {}
    for title, figure in figures.items():
        for kind, name in figure_names(title).items():
            files[name] = _picture(figure, kind)
            # Once laid out it stays so: finding places for everything again would take as long as drawing.
            figure.set_layout_engine("none")
    return files


def failure_files(
    stage: Stage, facts: Mapping[str, Any], diagnosis: Mapping[str, object], picture: "Figure | None" = None
) -> Files:
    """Write why a stage failed; arrays of the diagnosis go to a file of their own, and so does a picture."""
    text_name, arrays_name = failure_names(stage)
    arrays = {key: value for key, value in diagnosis.items() if isinstance(value, np.ndarray) and value.dtype != object}
    rest = {key: value for key, value in diagnosis.items() if key not in arrays}
    files = {text_name: json_bytes({**facts, "diagnosis": rest, "arrays": sorted(arrays)})}
    if arrays:
        files[arrays_name] = npz_bytes(arrays)
    if picture is not None:
        files[failure_picture(stage)] = _picture(picture, "png")
    return files


def _columns(names: tuple[str, ...], table: npt.NDArray[Any]) -> dict[str, npt.NDArray[Any]]:
    return dict(zip(names, table.T, strict=True))


def _picture(figure: "Figure", kind: str) -> bytes:
    buffer = io.BytesIO()
    # Without a date, the same figure always makes the same file.
    figure.savefig(buffer, format=kind, metadata={"CreationDate": None} if kind == "pdf" else None)
    return buffer.getvalue()


def _trajectory_csv(machine: Machine, samples: TrajectorySamples) -> bytes:
    decimals = max(DECIMALS, needed_decimals(samples.period_s, machine.acceleration_mps2))
    return format_csv(trajectory_columns(samples), decimals).encode()


def _csv(columns: Mapping[str, npt.NDArray[Any]]) -> bytes:
    return format_csv(columns).encode()
