"""The machine as its drives see it: five equations M(q) qdd + c(q, qd) + g(q) = F in actuator space.

They are regular wherever det H is not zero; at a singular pose, whatever H is solved for is NaN.
"""

from pipeline.machine.actuator_space.figures import (
    Amplification,
    Directed,
    DriveFigures,
    amplification,
    drive_figures,
    mode_words,
)
from pipeline.machine.actuator_space.gravity import gravity_forces, gravity_stiffness, least_stiffness
from pipeline.machine.actuator_space.inertia import mass_matrix, velocity_damping, velocity_forces
from pipeline.machine.actuator_space.rates import ActuatorRates, actuator_rates

__all__ = [
    "ActuatorRates",
    "Amplification",
    "Directed",
    "DriveFigures",
    "actuator_rates",
    "amplification",
    "drive_figures",
    "gravity_forces",
    "gravity_stiffness",
    "least_stiffness",
    "mass_matrix",
    "mode_words",
    "velocity_damping",
    "velocity_forces",
]
