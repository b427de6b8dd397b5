"""The machine: geometry, inverse and forward kinematics, statics, clearance, and the same in CasADi."""

from pipeline.machine.clearance import link_distances, link_rail_distances, min_distances
from pipeline.machine.geometry import MODES, Machine, build_machine
from pipeline.machine.kinematics import InverseSolution, forward_kinematics, inverse_kinematics
from pipeline.machine.statics import condition_number, det_sign, statics_matrix

__all__ = [
    "MODES",
    "InverseSolution",
    "Machine",
    "build_machine",
    "condition_number",
    "det_sign",
    "forward_kinematics",
    "inverse_kinematics",
    "link_distances",
    "link_rail_distances",
    "min_distances",
    "statics_matrix",
]
