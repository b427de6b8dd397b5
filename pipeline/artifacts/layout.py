"""The names of all files of a run folder, and which stage they belong to."""

from collections.abc import Iterable
from pathlib import Path

from pipeline.stage import STAGES, Stage

CONFIG = "config.yaml"
SUMMARY = "summary.json"
STATE = "state.json"
LOCK = ".lock"
SUPERSEDED = "superseded"

REGIONS_NPZ = "regions.npz"
ROUTE_NPZ = "route.npz"
ROUTE_CSV = "route.csv"
PATH_NPZ = "path.npz"
PATH_CSV = "path.csv"
CERTIFICATE_JSON = "certificate.json"
TRAJECTORY_NPZ = "trajectory.npz"
TRAJECTORY_CSV = "trajectory.csv"
TRAJECTORY_JSON = "trajectory.json"
BACK_CSV = "trajectory_back.csv"
BACK_JSON = "trajectory_back.json"
REPORT = "report.html"

RESULT = {
    Stage.REGIONS: REGIONS_NPZ,
    Stage.ROUTE: ROUTE_NPZ,
    Stage.REFINE: PATH_NPZ,
    Stage.CERTIFY: CERTIFICATE_JSON,
    Stage.RETIME: TRAJECTORY_NPZ,
}
"""The file each stage's result is loaded back from, exactly."""

_FIXED = {
    Stage.REGIONS: (REGIONS_NPZ,),
    Stage.ROUTE: (ROUTE_NPZ, ROUTE_CSV),
    Stage.REFINE: (PATH_NPZ, PATH_CSV),
    Stage.CERTIFY: (CERTIFICATE_JSON,),
    Stage.RETIME: (TRAJECTORY_NPZ, TRAJECTORY_CSV, TRAJECTORY_JSON, BACK_CSV, BACK_JSON),
    Stage.FIGURES: (REPORT,),
}
_FIGURES = "figures"
_PICTURE_KINDS = ("png", "pdf")
_FAILED = "failed"
_SIGHTS = {
    Stage.REGIONS: ((REGIONS_NPZ, "the region table, one array per column"),),
    Stage.ROUTE: ((ROUTE_CSV, "the route, one row per step"),),
    Stage.REFINE: ((PATH_NPZ, "the path as splines"), (PATH_CSV, "the path, densely sampled")),
    Stage.CERTIFY: ((CERTIFICATE_JSON, "the proof that the path is free of singularities, and its bounds"),),
    Stage.RETIME: (
        (TRAJECTORY_CSV, "for the controller: one row per period"),
        (BACK_CSV, "the same for the way back"),
    ),
    Stage.FIGURES: (
        (REPORT, "to open in a browser: the machine in motion, kappa around it, the proof, all figures"),
        (_FIGURES, "pictures: the route, the machine, kappa, clearance, motion over time"),
    ),
}


def figure_names(title: str) -> dict[str, str]:
    """Where the picture with this name goes, by the kind of file: as pixels and as vectors."""
    return {kind: f"{_FIGURES}/{title}.{kind}" for kind in _PICTURE_KINDS}


def failure_names(stage: Stage) -> tuple[str, str]:
    """Where the diagnosis of a failed stage goes: its text and numbers, its arrays."""
    return f"{_FAILED}/{stage}.json", f"{_FAILED}/{stage}.npz"


def failure_picture(stage: Stage) -> str:
    """Where the picture of a failed stage goes."""
    return f"{_FAILED}/{stage}.png"


def failure_report(stage: Stage) -> str:
    """Where the report of a run that failed at a stage goes."""
    return f"{_FAILED}/{stage}.html"


def existing_files(folder: Path, stage: Stage) -> list[str]:
    """List the files of a stage in a folder, those of its failure included; names relative to the folder."""
    names = [*_FIXED[stage], *failure_names(stage), failure_picture(stage), failure_report(stage)]
    if stage is Stage.FIGURES:
        found = [path.name for kind in _PICTURE_KINDS for path in (folder / _FIGURES).glob(f"*.{kind}")]
        names += sorted(f"{_FIGURES}/{name}" for name in found)
    return [name for name in names if (folder / name).is_file()]


def foreign_files(folder: Path) -> list[str]:
    """Files that bear the name of a result in a folder that is not known to be a run folder."""
    stages = [name for stage in STAGES for name in existing_files(folder, stage)]
    return [name for name in (CONFIG, SUMMARY) if (folder / name).exists()] + stages


def sights(folder: Path, stages: Iterable[Stage]) -> list[tuple[Path, str]]:
    """List what is worth looking at after these stages, and what it is."""
    known = [sight for stage in stages for sight in _SIGHTS[stage]]
    found = [(folder / name, what) for name, what in (*known, (SUMMARY, "every figure of this run"))]
    return [(path, what) for path, what in found if path.exists()]
