"""What the summary of a run states of its motions, to be verified."""

import json
import pathlib

import numpy as np

from pipeline.arrays import FloatArray
from pipeline.artifacts.layout import SUMMARY
from pipeline.certify.recheck.time_law import StatedMotion
from pipeline.errors import UsageError
from pipeline.machine.geometry import ACTUATORS
from pipeline.summary.trajectory import PROVEN

_ADVICE = "\n  What to change: time the path again: gantry-tau retime CONFIG --force"


def stated_motions(folder: pathlib.Path) -> dict[str, StatedMotion]:
    """Read what is stated of the motion there ("trajectory") and back ("way back"), as far as these were made.

    Raises
    ------
    UsageError
        When the summary is damaged, or has a motion but states nothing of it that can be verified.
    """
    file = folder / SUMMARY
    try:
        there = json.loads(file.read_bytes()).get("trajectory", {})
        sections = {"trajectory": there, "way back": there.get("back", {})}
        return {name: _stated(part[PROVEN]) for name, part in sections.items() if part.get("status") == "done"}
    except FileNotFoundError:
        return {}
    except (KeyError, TypeError, ValueError, AttributeError) as error:
        raise UsageError(f"{file} does not state what is proven of its motion: {error!r}{_ADVICE}") from None


def _stated(section: dict[str, object]) -> StatedMotion:
    fractions: dict[str, FloatArray] = {
        name: _five(section[name]) for name in ("velocity", "acceleration", "jerk") if name in section
    }
    return StatedMotion(str(section["law_sha256"]), fractions)


def _five(value: object) -> FloatArray:
    if not (isinstance(value, list) and len(value) == len(ACTUATORS)):
        raise ValueError(f"expected {len(ACTUATORS)} numbers")
    return np.array([float(number) for number in value])
