"""The machine as its drives see it: five equations M(q) qdd + c(q, qd) + g(q) = F in actuator space.

They are regular wherever det H is not zero; at a singular pose, whatever H is solved for is NaN.
"""

from pipeline.machine.actuator_space.gravity import gravity_forces, gravity_stiffness
from pipeline.machine.actuator_space.inertia import mass_matrix, velocity_damping, velocity_forces
from pipeline.machine.actuator_space.rates import ActuatorRates, actuator_rates

__all__ = [
    "ActuatorRates",
    "actuator_rates",
    "gravity_forces",
    "gravity_stiffness",
    "mass_matrix",
    "velocity_damping",
    "velocity_forces",
]
