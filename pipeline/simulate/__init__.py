"""A simulated twin: the real machine, with its drives and their controllers, follows a commanded motion."""

from pipeline.simulate.drives import Drives, build_drives, ideal_drives
from pipeline.simulate.motion import Motion, controller_period, plan_motion
from pipeline.simulate.plant import Deviations, Plant, build_plant, require_masses
from pipeline.simulate.result import Ending, Simulation, Verdict
from pipeline.simulate.simulate import simulate_motion

__all__ = [
    "Deviations",
    "Drives",
    "Ending",
    "Motion",
    "Plant",
    "Simulation",
    "Verdict",
    "build_drives",
    "build_plant",
    "controller_period",
    "ideal_drives",
    "plan_motion",
    "require_masses",
    "simulate_motion",
]
