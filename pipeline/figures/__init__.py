"""The figures of a run, for matplotlib; saving them is up to the caller.

Only matplotlib's object-oriented interface is used: no windows, no global state, nothing to close.
"""

from pipeline.figures.bodies import bodies_figure
from pipeline.figures.clearance import clearance_figure
from pipeline.figures.kappa import kappa_figure
from pipeline.figures.machine import machine_figure, postures_figure
from pipeline.figures.maps.panels import kappa_map_figure
from pipeline.figures.maps.regions import regions_figure
from pipeline.figures.maps.route import route_figure
from pipeline.figures.maps.volume import workspace_volume_figure
from pipeline.figures.maps.workspace import workspace_figure
from pipeline.figures.proven.pose_error import pose_error_figure
from pipeline.figures.proven.proof import proof_figure
from pipeline.figures.run_figures import FIGURES, RunData, RunFigure, all_figures
from pipeline.figures.time.drives import drives_figure, has_masses
from pipeline.figures.time.loads import has_loads, loads_figure, usage_figure
from pipeline.figures.time.measured import measured_figure
from pipeline.figures.time.phase import phase_figure
from pipeline.figures.time.pose import pose_figure
from pipeline.figures.time.trajectory import trajectory_figure

__all__ = [
    "FIGURES",
    "RunData",
    "RunFigure",
    "all_figures",
    "bodies_figure",
    "clearance_figure",
    "drives_figure",
    "has_loads",
    "has_masses",
    "kappa_figure",
    "kappa_map_figure",
    "loads_figure",
    "machine_figure",
    "measured_figure",
    "phase_figure",
    "pose_error_figure",
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
