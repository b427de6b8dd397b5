"""The sidecar `trajectory.json`: all that a program or a person needs to use `trajectory.csv` rightly."""

from typing import Any

from pipeline.config import Config
from pipeline.config_file import config_sha256
from pipeline.export.columns import PER_ACTUATOR, trajectory_meanings
from pipeline.machine.geometry import ACTUATORS, Machine
from pipeline.retime.result import TrajectorySamples
from pipeline.retime.verify import Usage

_CONVENTIONS = (
    "A row per period: row k is at k * period_s, counted from zero.",
    "The first row is the start at rest: velocities are zero, accelerations are those the motion begins with.",
    "The last row is the goal at rest, at duration_s: velocities and accelerations are zero.",
    "Accelerations jump at instants that need not be rows; velocities and positions are continuous.",
    "SI units; angles in radians; actuators in the order c1, c2, c3 (carts), l2b, l3b (telescopes).",
    "Comma separated, decimal points, LF line ends, one header line.",
)


def sidecar(config: Config, machine: Machine, samples: TrajectorySamples, usage: Usage) -> dict[str, Any]:
    """Describe a sampled trajectory: columns, period, duration, limits and how much of them is used.

    Usage is the largest fraction of each limit, a list in the order of the actuators. All values are plain
    (dictionaries, lists, texts, numbers), ready to be written as JSON.
    """
    return {
        "name": config.name,
        "config_sha256": config_sha256(config),
        "period_s": samples.period_s,
        "duration_s": samples.duration_s,
        "samples": len(samples),
        "conventions": list(_CONVENTIONS),
        "columns": [meaning._asdict() for meaning in trajectory_meanings()],
        "limits": _limits(machine),
        "usage": {"velocity": usage.velocity.tolist(), "acceleration": usage.acceleration.tolist()},
    }


def _limits(machine: Machine) -> dict[str, dict[str, Any]]:
    """Limits by actuator: where it may be (travel or stroke), how fast it may move and accelerate."""
    return {
        actuator: {
            "column": column,
            "position_m": position,
            "velocity_mps": velocity,
            "acceleration_mps2": acceleration,
        }
        for actuator, column, position, velocity, acceleration in zip(
            ACTUATORS,
            PER_ACTUATOR[0].names,
            machine.actuator_limits_m.tolist(),
            machine.velocity_mps.tolist(),
            machine.acceleration_mps2.tolist(),
            strict=True,
        )
    }
