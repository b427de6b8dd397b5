"""The pictures of a run, as matplotlib figures; saving them is the caller's.

Only matplotlib's object-oriented interface is used: no windows, no global state, nothing to close.
"""

from matplotlib.figure import Figure

from pipeline.certify.recheck import KappaProfile
from pipeline.compare.figures.clearance import clearance_figure
from pipeline.compare.figures.kappa import kappa_figure
from pipeline.compare.figures.loads import has_loads, loads_figure, usage_figure
from pipeline.compare.figures.machine import machine_figure, postures_figure
from pipeline.compare.figures.map_panels import kappa_map_figure
from pipeline.compare.figures.measured import measured_figure
from pipeline.compare.figures.phase import phase_figure
from pipeline.compare.figures.pose import pose_figure
from pipeline.compare.figures.proof import proof_figure
from pipeline.compare.figures.regions import regions_figure
from pipeline.compare.figures.route import route_figure
from pipeline.compare.figures.trajectory import trajectory_figure
from pipeline.compare.figures.volume import workspace_volume_figure
from pipeline.compare.figures.workspace import workspace_figure
from pipeline.config import Config
from pipeline.machine.geometry import Machine
from pipeline.refine.measure import PathSamples
from pipeline.retime.result import Trajectory, TrajectorySamples
from pipeline.route.result import Route
from pipeline.route.table import RegionTable

__all__ = [
    "all_figures",
    "clearance_figure",
    "has_loads",
    "kappa_figure",
    "kappa_map_figure",
    "loads_figure",
    "machine_figure",
    "measured_figure",
    "phase_figure",
    "pose_figure",
    "postures_figure",
    "proof_figure",
    "regions_figure",
    "route_figure",
    "trajectory_figure",
    "usage_figure",
    "workspace_figure",
    "workspace_volume_figure",
]


def all_figures(
    config: Config,
    machine: Machine,
    route: Route,
    coarse: PathSamples | None = None,
    refined: PathSamples | None = None,
    trajectory: TrajectorySamples | None = None,
    timed: Trajectory | None = None,
    regions: RegionTable | None = None,
    proven: KappaProfile | None = None,
) -> dict[str, Figure]:
    """Draw every figure that the results at hand allow; the keys are the stems of the files to be."""
    figures = {
        "route": route_figure(config, machine, route, coarse, refined),
        "machine": machine_figure(machine, route),
    }
    if regions is not None:
        figures["regions"] = regions_figure(config, regions)
    if coarse is not None and refined is not None:
        figures["kappa"] = kappa_figure(config, route, coarse, refined)
        figures["clearance"] = clearance_figure(config, machine, coarse, refined)
    if refined is not None and proven is not None:
        figures["proof"] = proof_figure(config, refined, proven)
    if coarse is not None and trajectory is not None:
        figures["pose"] = pose_figure(config, machine, route, coarse, trajectory)
    if trajectory is not None:
        figures["trajectory"] = trajectory_figure(machine, trajectory)
    if timed is not None:
        if has_loads(timed):
            figures["loads"] = loads_figure(timed)
        figures |= {"usage": usage_figure(timed), "phase": phase_figure(timed)}
    return figures
