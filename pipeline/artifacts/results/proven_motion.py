"""What the summary of a run states of its motions, to be verified."""

import json
import pathlib
from typing import Any

import numpy as np

from pipeline.arrays import FloatArray
from pipeline.artifacts.layout import BACK_CSV, SUMMARY, TRAJECTORY_CSV, TRAJECTORY_NPZ
from pipeline.certify.recheck.time_law import StatedMotion
from pipeline.errors import UsageError
from pipeline.machine.geometry import ACTUATORS, LINKS
from pipeline.summary.trajectory import PROVEN

_FILES = {
    "trajectory": (TRAJECTORY_NPZ, TRAJECTORY_CSV, BACK_CSV),
    "way back": (BACK_CSV,),
}
"""Files that a run has only if it has the motion."""
_SUBJECTS = {name: len(ACTUATORS) for name in ("velocity", "acceleration", "jerk", "force")} | {
    "link_force": len(LINKS),
    "tcp_speed": 1,
    "tcp_acceleration": 1,
}
"""How many numbers are stated of every quantity."""
_ADVICE = "\n  What to change: time the path again: gantry-tau retime CONFIG --force"


def stated_motions(folder: pathlib.Path) -> dict[str, StatedMotion | None]:
    """Read what is stated of the motion there ("trajectory") and back ("way back"), as far as these are in the folder.

    The files of a motion say whether there is one, not the summary; None if nothing is stated of it.

    Raises
    ------
    UsageError
        When the summary is damaged.
    """
    file = folder / SUMMARY
    try:
        there = json.loads(file.read_bytes()).get("trajectory", {}) if file.exists() else {}
        sections = {"trajectory": there, "way back": there.get("back", {})}
        stated = {name: _stated(part[PROVEN]) for name, part in sections.items() if PROVEN in part}
    except (KeyError, TypeError, ValueError, AttributeError) as error:
        raise UsageError(f"{file} does not state what is proven of its motion: {error!r}{_ADVICE}") from None
    driven = {name for name, files in _FILES.items() if any((folder / one).exists() for one in files)}
    return {name: stated.get(name) for name in _FILES if name in driven or name in stated}


def _stated(section: dict[str, Any]) -> StatedMotion:
    return StatedMotion(str(section["law_sha256"]), _numbers(section), _numbers(section.get("peak", {})))


def _numbers(section: object) -> dict[str, FloatArray]:
    """Read the numbers of every quantity that a section has."""
    if not isinstance(section, dict):
        raise TypeError(f"expected numbers by name, not {section!r}")
    return {name: _list(section[name], count) for name, count in _SUBJECTS.items() if name in section}


def _list(value: object, count: int) -> FloatArray:
    if not (isinstance(value, list) and len(value) == count):
        raise ValueError(f"expected {count} numbers")
    return np.array([float(number) for number in value])
