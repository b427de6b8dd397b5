"""What is in a run folder."""

import json
from pathlib import Path
from typing import Any

ALL = ["regions", "route", "refine", "certify", "retime", "figures"]
RESULT_FILES = {
    "regions.npz",
    "route.npz",
    "route.csv",
    "path.npz",
    "path.csv",
    "certificate.json",
    "trajectory.npz",
    "trajectory.csv",
    "trajectory.json",
    "trajectory_back.csv",
    "trajectory_back.json",
    "report.html",
    "figures/route.png",
    "figures/kappa.png",
}
BOOKS = {"config.yaml", "summary.json", "state.json", ".lock"}


def files(folder: Path) -> set[str]:
    """Names of all files in a folder."""
    return {path.relative_to(folder).as_posix() for path in folder.rglob("*") if path.is_file()}


def content(folder: Path) -> dict[str, bytes]:
    """Content of all files but the lock, which holds a process number."""
    return {name: (folder / name).read_bytes() for name in files(folder) - {".lock"}}


def summary(folder: Path) -> dict[str, Any]:
    """Read the summary, insisting that it is strict JSON."""

    def refuse(name: str) -> None:
        raise AssertionError(f"{name} is no JSON")

    data: dict[str, Any] = json.loads((folder / "summary.json").read_text(), parse_constant=refuse)
    return data
