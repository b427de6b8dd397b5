"""The pictures of a run, as matplotlib figures; saving them is the caller's.

Only matplotlib's object-oriented interface is used: no windows, no global state, nothing to close.
"""

from matplotlib.figure import Figure

from pipeline.certify.recheck import KappaProfile
from pipeline.config import Config
from pipeline.figures.clearance import clearance_figure
from pipeline.figures.kappa import kappa_figure
from pipeline.figures.machine import machine_figure, postures_figure
from pipeline.figures.maps.panels import kappa_map_figure
from pipeline.figures.maps.regions import regions_figure
from pipeline.figures.maps.route import route_figure
from pipeline.figures.maps.volume import workspace_volume_figure
from pipeline.figures.maps.workspace import workspace_figure
from pipeline.figures.proof import proof_figure
from pipeline.figures.time.loads import has_loads, loads_figure, usage_figure
from pipeline.figures.time.measured import measured_figure
from pipeline.figures.time.phase import phase_figure
from pipeline.figures.time.pose import pose_figure
from pipeline.figures.time.trajectory import trajectory_figure
from pipeline.machine.geometry import Machine
from pipeline.refine.measure import PathSamples
from pipeline.retime.result import Trajectory, TrajectorySamples
from pipeline.route.regions.table import RegionTable
from pipeline.route.result import Route

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
