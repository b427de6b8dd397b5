"""All figures of a run: a row each, with the results that it is drawn from."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

from matplotlib.figure import Figure

from pipeline.certify.following.steps import FollowingProfile
from pipeline.certify.recheck import KappaProfile
from pipeline.config import Config
from pipeline.figures.bodies import bodies_figure, has_pairs
from pipeline.figures.clearance import clearance_figure
from pipeline.figures.kappa import kappa_figure
from pipeline.figures.machine import machine_figure
from pipeline.figures.maps.regions import regions_figure
from pipeline.figures.maps.route import route_figure
from pipeline.figures.proven.following import following_figure
from pipeline.figures.proven.pose_error import pose_error_figure
from pipeline.figures.proven.proof import proof_figure
from pipeline.figures.time.drives import drives_figure, has_masses
from pipeline.figures.time.loads import has_loads, loads_figure, usage_figure
from pipeline.figures.time.phase import phase_figure
from pipeline.figures.time.pose import pose_figure
from pipeline.figures.time.trajectory import trajectory_figure
from pipeline.machine.geometry import Machine
from pipeline.pose_error import PoseError, SampledError
from pipeline.refine.measure import PathSamples
from pipeline.retime.result import Trajectory, TrajectorySamples
from pipeline.route.regions.table import RegionTable
from pipeline.route.result import Route


@dataclass(frozen=True, eq=False)
class RunData:
    """Results of a run that its figures are drawn from; None for what is missing.

    Attributes
    ----------
    config, machine
        Present in every run.
    route : Route or None
        The route.
    regions : RegionTable or None
        The regions that the route was chosen from.
    coarse, refined : PathSamples or None
        Dense samples of both paths.
    kappa_profile : KappaProfile or None
        The proven bound of kappa, box by box.
    following : FollowingProfile or None
        By how much drives may be off the path, over s.
    pose_error : PoseError or None
        The proven error of the tool.
    sampled_error : SampledError or None
        The same at samples.
    trajectory : Trajectory or None
        The refined path in time.
    trajectory_samples : TrajectorySamples or None
        Its rows, one per period.
    """

    config: Config
    machine: Machine
    route: Route | None = None
    regions: RegionTable | None = None
    coarse: PathSamples | None = None
    refined: PathSamples | None = None
    kappa_profile: KappaProfile | None = None
    following: FollowingProfile | None = None
    pose_error: PoseError | None = None
    sampled_error: SampledError | None = None
    trajectory: Trajectory | None = None
    trajectory_samples: TrajectorySamples | None = None


class RunFigure(NamedTuple):
    """A figure of a run.

    Attributes
    ----------
    name : str
        Stem of its files.
    draw : function
        Draws it from results, in the order of `needs`, then `uses`.
    needs : tuple of str
        Fields of `RunData` without which there is no figure.
    uses : tuple of str
        Fields that are drawn as well if they are there.
    applies : function of the results needed
        Whether there is anything to draw.
    """

    name: str
    draw: Callable[..., Figure]
    needs: tuple[str, ...]
    uses: tuple[str, ...] = ()
    applies: Callable[..., bool] = lambda *results: True


FIGURES = (
    RunFigure("route", route_figure, ("config", "machine", "route"), uses=("coarse", "refined")),
    RunFigure("machine", machine_figure, ("machine", "route"), uses=("config",)),
    RunFigure("regions", regions_figure, ("config", "regions")),
    RunFigure("kappa", kappa_figure, ("config", "route", "coarse", "refined")),
    RunFigure("clearance", clearance_figure, ("config", "machine", "coarse", "refined")),
    RunFigure("bodies", bodies_figure, ("config", "machine", "refined"), applies=has_pairs),
    RunFigure("proof", proof_figure, ("config", "refined", "kappa_profile")),
    RunFigure("following", following_figure, ("following",)),
    RunFigure("pose_error", pose_error_figure, ("pose_error", "sampled_error")),
    RunFigure("pose", pose_figure, ("config", "machine", "route", "coarse", "trajectory_samples")),
    RunFigure("trajectory", trajectory_figure, ("machine", "trajectory_samples")),
    RunFigure("loads", loads_figure, ("trajectory",), applies=has_loads),
    RunFigure("drives", drives_figure, ("trajectory",), applies=has_masses),
    RunFigure("usage", usage_figure, ("trajectory",)),
    RunFigure("phase", phase_figure, ("trajectory",)),
)
"""All figures of a run, in their order."""


def all_figures(data: RunData, figures: tuple[RunFigure, ...] = FIGURES) -> dict[str, Figure]:
    """Draw every figure for which there are results; the keys are the stems of their files."""
    drawn = {}
    for row in figures:
        needed = [getattr(data, name) for name in row.needs]
        if all(result is not None for result in needed) and row.applies(*needed):
            drawn[row.name] = row.draw(*needed, *(getattr(data, name) for name in row.uses))
    return drawn
