"""The names of all files of a run folder."""

from collections.abc import Iterable
from pathlib import Path

from pipeline.stage import Stage

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
FIGURES = "figures"

_FIGURE_KINDS = ("png", "pdf")
FIGURE_PATTERNS = tuple(f"{FIGURES}/*.{kind}" for kind in _FIGURE_KINDS)
"""What the names of figures match."""
_FAILED = "failed"


def figure_names(title: str) -> dict[str, str]:
    """Name the files of a figure by their kind: as pixels and as vectors."""
    return {kind: f"{FIGURES}/{title}.{kind}" for kind in _FIGURE_KINDS}


def failure_names(stage: Stage) -> tuple[str, str]:
    """Name the files of a failed stage's diagnosis: its text and numbers, its arrays."""
    return f"{_FAILED}/{stage}.json", f"{_FAILED}/{stage}.npz"


def failure_picture(stage: Stage) -> str:
    """Name the picture of a failed stage."""
    return f"{_FAILED}/{stage}.png"


def failure_report(stage: Stage) -> str:
    """Name the report of a run that failed at a stage."""
    return f"{_FAILED}/{stage}.html"


def failure_pattern(stage: Stage) -> str:
    """Give what the names of all files of a failed stage match."""
    return f"{_FAILED}/{stage}.*"


def existing_files(folder: Path, patterns: Iterable[str]) -> list[str]:
    """List the files in a folder whose names, relative to it, match one of the patterns."""
    found = [path for pattern in patterns for path in sorted(folder.glob(pattern)) if path.is_file()]
    return [path.relative_to(folder).as_posix() for path in found]
