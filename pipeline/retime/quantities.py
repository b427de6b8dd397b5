"""The limited quantities of a motion: what they are called, whose they are, in which unit, and their limits."""

from dataclasses import dataclass

import numpy as np

from pipeline.arrays import FloatArray
from pipeline.machine.geometry import ACTUATORS, LINKS, Machine


@dataclass(frozen=True)
class Kind:
    """A limited quantity: its name, its unit, what has it, and the power of time in it (None: none by itself)."""

    name: str
    unit: str
    subjects: tuple[str, ...]
    power: int | None = None

    @property
    def words(self) -> str:
        """The name in words."""
        return self.name.replace("_", " ").replace("tcp", "TCP")


KINDS = (
    Kind("velocity", "m/s", ACTUATORS, 1),
    Kind("acceleration", "m/s^2", ACTUATORS, 2),
    Kind("jerk", "m/s^3", ACTUATORS, 3),
    Kind("force", "N", ACTUATORS),
    Kind("link_force", "N", tuple(f"link {link}" for link in LINKS)),
    Kind("tcp_speed", "m/s", ("TCP",), 1),
    Kind("tcp_acceleration", "m/s^2", ("TCP",), 2),
)
"""All limited quantities; a link's force is along its axis."""

JERK = "jerk"
FORCES = ("force", "link_force")


def kind_named(name: str) -> Kind:
    """Find a limited quantity by its name."""
    return next(kind for kind in KINDS if kind.name == name)


def limits(machine: Machine) -> dict[str, FloatArray]:
    """Limits by the names of `KINDS`, one for each subject; infinite where there is none.

    An actuator whose velocity limit is zero is locked: that it does not move is seen to before all planning, and it
    limits nothing.
    """
    return {
        "velocity": np.where(machine.velocity_mps > 0.0, machine.velocity_mps, np.inf),
        "acceleration": machine.acceleration_mps2,
        "jerk": machine.jerk_mps3,
        "force": machine.force_n,
        "link_force": np.full(len(LINKS), machine.link_force_n),
        "tcp_speed": np.array([machine.tcp_speed_mps]),
        "tcp_acceleration": np.array([machine.tcp_acceleration_mps2]),
    }


def limited(machine: Machine) -> tuple[str, ...]:
    """Names of the quantities that have a limit and can be looked at; forces can with masses only."""
    known = limits(machine).items()
    unknown = FORCES if machine.masses is None else ()
    return tuple(name for name, values in known if np.isfinite(values).any() and name not in unknown)
