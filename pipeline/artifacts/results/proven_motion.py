"""What the summary of a run states of its motions, to be verified."""

import json
import pathlib

import numpy as np

from pipeline.arrays import FloatArray
from pipeline.artifacts.layout import BACK_CSV, SUMMARY, TRAJECTORY_CSV, TRAJECTORY_NPZ
from pipeline.certify.recheck.time_law import StatedMotion
from pipeline.errors import UsageError
from pipeline.machine.geometry import ACTUATORS
from pipeline.summary.trajectory import PROVEN

_FILES = {
    "trajectory": (TRAJECTORY_NPZ, TRAJECTORY_CSV, BACK_CSV),
    "way back": (BACK_CSV,),
}
"""Files that a run has only if it has the motion."""
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


def _stated(section: dict[str, object]) -> StatedMotion:
    fractions: dict[str, FloatArray] = {
        name: _five(section[name]) for name in ("velocity", "acceleration", "jerk") if name in section
    }
    return StatedMotion(str(section["law_sha256"]), fractions)


def _five(value: object) -> FloatArray:
    if not (isinstance(value, list) and len(value) == len(ACTUATORS)):
        raise ValueError(f"expected {len(ACTUATORS)} numbers")
    return np.array([float(number) for number in value])
