"""The coarse path in motion, beside which the refined one is shown."""

from collections.abc import Callable
from dataclasses import dataclass

from pipeline.compare.blend import TOLERANCE_M, blended
from pipeline.compare.motion import MotionFigures, common_retiming, measure_motion, retimed
from pipeline.config import Config, RetimeConfig
from pipeline.errors import NoSolutionError, PipelineError
from pipeline.refine.result import Path
from pipeline.report.data import Motion
from pipeline.report.motion import build_motion
from pipeline.retime.result import Trajectory

Retime = Callable[[Config, RetimeConfig, Path], Trajectory]


@dataclass(frozen=True, eq=False)
class CoarseMotion:
    """The coarse path in motion, if it can be timed; the note explains how, or why not."""

    note: str
    motion: Motion | None = None
    figures: MotionFigures | None = None


def drive_coarse(config: Config, coarse: Path, retime: Retime = retimed) -> CoarseMotion:
    """Drive the coarse path as a controller would; if that is impossible, the run has not failed."""
    try:
        trajectory = retime(config, common_retiming(config), blended(coarse))
        motion = build_motion(config, trajectory, "coarse")
    except PipelineError as error:
        reason = error.reason if isinstance(error, NoSolutionError) else str(error)
        return CoarseMotion(f"The coarse path is not shown in motion: {reason}.")
    note = (
        "The coarse path joins the steps of the route by straight moves in actuator space; it is timed like the "
        f"refined one, at full speed, with its corners rounded by at most {1e3 * TOLERANCE_M:g} mm of actuator travel."
    )
    return CoarseMotion(note, motion, measure_motion(trajectory))
