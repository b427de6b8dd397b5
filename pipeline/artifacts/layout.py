"""The names of all files of a run folder."""

from collections.abc import Iterable
from fnmatch import fnmatchcase
from pathlib import Path

from pipeline.stage import Stage

CONFIG = "config.yaml"
SUMMARY = "summary.json"
STATE = "state.json"
LOCK = ".lock"
SUPERSEDED = "superseded"
BOOKS = (CONFIG, SUMMARY, STATE)
"""What every run folder has, whatever stages have run."""

REGIONS_NPZ = "regions.npz"
ROUTE_NPZ = "route.npz"
ROUTE_CSV = "route.csv"
PATH_NPZ = "path.npz"
PATH_CSV = "path.csv"
CORRECTION_CSV = "correction.csv"
CERTIFICATE_JSON = "certificate.json"
CALIBRATION_JSON = "calibration.json"
FOLLOWING_CSV = "following.csv"
POSE_ERROR_CSV = "pose_error.csv"
POSE_ERROR_NPZ = "pose_error.npz"
TRAJECTORY_NPZ = "trajectory.npz"
TRAJECTORY_CSV = "trajectory.csv"
TRAJECTORY_JSON = "trajectory.json"
BACK_CSV = "trajectory_back.csv"
BACK_JSON = "trajectory_back.json"
REPORT = "report.html"
FIGURES = "figures"

ATLAS_JSON = "atlas.json"
ATLAS_PICTURE = "atlas.png"
ATLAS_ROUTES = "routes"
ATLAS_RUNS = "runs"
TOUR_JSON = "tour.json"
TOUR_CSV = "tour.csv"
TOUR_POSES = "poses.csv"
TOUR_LEGS = "legs"
"""What the folder of an atlas has: its figures, a picture of them, a route and a run per pair of stations."""

_PIXELS, _VECTORS = "png", "pdf"
FIGURE_PATTERNS = tuple(f"{FIGURES}/*.{kind}" for kind in (_PIXELS, _VECTORS))
"""What the names of figures match."""
_FAILED = "failed"


def figure_names(title: str, pdf: bool) -> dict[str, str]:
    """Name the files of a figure by their kind: as pixels and, on request, as vectors."""
    return {kind: f"{FIGURES}/{title}.{kind}" for kind in (_PIXELS, *((_VECTORS,) if pdf else ()))}


def failure_names(stage: Stage) -> tuple[str, str]:
    """Name the files of a failed stage's diagnosis: its text and numbers, its arrays."""
    return f"{_FAILED}/{stage}.json", f"{_FAILED}/{stage}.npz"


def failure_picture(stage: Stage) -> str:
    """Name the picture of a failed stage."""
    return f"{_FAILED}/{stage}.png"


def failure_report(stage: Stage) -> str:
    """Name the report of a run that failed at a stage."""
    return f"{_FAILED}/{stage}.html"


def failure_files_of(stage: Stage) -> tuple[str, ...]:
    """Name all files of a failed stage."""
    return (*failure_names(stage), failure_picture(stage), failure_report(stage))


def existing_files(folder: Path, patterns: Iterable[str]) -> list[str]:
    """List what is in a folder under names, relative to it, that match one of the patterns: files, links, anything."""
    found = [path for pattern in patterns for path in sorted(folder.glob(pattern))]
    return [path.relative_to(folder).as_posix() for path in found]


def own_files(folder: Path, patterns: Iterable[str], recorded: Iterable[str]) -> list[str]:
    """List the files of a stage: all under a name of its own, and of those that match a pattern the recorded ones.

    A folder of figures may hold other pictures, too.
    """
    wanted = list(patterns)
    names = [name for name in wanted if not _is_pattern(name)]
    names += [name for name in recorded if name not in names and any(fnmatchcase(name, one) for one in wanted)]
    return [name for name in names if (folder / name).exists()]


def _is_pattern(name: str) -> bool:
    return "*" in name
