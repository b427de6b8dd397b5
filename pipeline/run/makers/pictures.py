"""Each figure of a run as files, and the stage after which it can be drawn."""

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from pipeline.artifacts.results.figures import figure_files
from pipeline.artifacts.results.pose_error import load_pose_error
from pipeline.figures import RunData, RunFigure, all_figures
from pipeline.pose_error import sample_pose_error
from pipeline.retime import sample_trajectory
from pipeline.run.makers.following import proven_following
from pipeline.stage import STAGES, Stage

if TYPE_CHECKING:
    from pipeline.pose_error import SampledError
    from pipeline.retime.result import TrajectorySamples
    from pipeline.run.results import Results

_MOST_SAMPLED = 100
"""Values of s at most at which the error of the tool is sampled."""


def _trajectory_samples(results: "Results") -> "TrajectorySamples":
    return sample_trajectory(results.trajectory, results.config.retime.period_s)


def sampled_error(results: "Results") -> "SampledError | None":
    """Sample the error of the tool in the middle of every interval of its bound, of at most so many."""
    found = results.derive(load_pose_error)
    if found is None:
        return None
    middles = found.middles[:: len(found.middles) // _MOST_SAMPLED + 1]
    return sample_pose_error(results.refinement.path, found.uncertainty, middles)


_SOURCES: dict[str, tuple[Stage, Callable[["Results"], Any]]] = {
    "regions": (Stage.REGIONS, lambda results: results.regions),
    "route": (Stage.ROUTE, lambda results: results.route),
    "coarse": (Stage.REFINE, lambda results: results.samples[0]),
    "refined": (Stage.REFINE, lambda results: results.samples[1]),
    "kappa_profile": (Stage.CERTIFY, lambda results: results.profile),
    "following": (Stage.CERTIFY, lambda results: results.derive(proven_following)),
    "pose_error": (Stage.CERTIFY, lambda results: results.derive(load_pose_error)),
    "sampled_error": (Stage.CERTIFY, lambda results: results.derive(sampled_error)),
    "trajectory": (Stage.RETIME, lambda results: results.trajectory),
    "trajectory_samples": (Stage.RETIME, lambda results: results.derive(_trajectory_samples)),
}
"""Fields of `RunData`: the stage after which they are known, and where they come from."""


def last_stage(figure: RunFigure) -> Stage:
    """Name the last stage that a figure needs."""
    known = [_SOURCES[name][0] for name in (*figure.needs, *figure.uses) if name in _SOURCES]
    return max(known, key=STAGES.index, default=Stage.REGIONS)


def picture(figure: RunFigure, results: "Results") -> dict[str, bytes]:
    """Draw one figure; no files if there is nothing to draw."""
    names = {name for name in (*figure.needs, *figure.uses) if name in _SOURCES}
    data = RunData(results.config, results.machine, **{name: _SOURCES[name][1](results) for name in names})
    return figure_files(all_figures(data, (figure,)), results.config.figures.pdf)
