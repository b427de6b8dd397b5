"""The sidecar `trajectory.json`: all that a program or a person needs to use `trajectory.csv` correctly."""

import math
from collections.abc import Iterable
from typing import Any

from pipeline.arrays import FloatArray
from pipeline.config import Config
from pipeline.config.file import config_sha256
from pipeline.export.trajectory_columns import POSITIONS, TRAJECTORY_COLUMNS, TrajectoryColumn
from pipeline.machine.actuator_space.controller_units import ControllerUnits, controller_units
from pipeline.machine.geometry import ACTUATORS, Machine
from pipeline.retime.quality.interpolation import Interpolation
from pipeline.retime.quantities import Quantities, both_sides
from pipeline.retime.result import TrajectorySamples
from pipeline.retime.usage import Usage
from pipeline.summary.trajectory import interpolation_section

_CONVENTIONS = (
    "A row per period: row k is at k * period_s, counted from zero.",
    "The first row is the start at rest: velocities are zero, accelerations are those the motion begins with.",
    "The last row is the goal at rest, at duration_s: velocities and accelerations are zero.",
    "Positions and velocities are continuous; accelerations are, too, where jerk is limited, and jump elsewhere.",
    "SI units; angles in radians; actuators in the order c1, c2, c3 (carts), l2b, l3b (telescopes).",
    "Positions q of actuators, and their limits, are the controller's; in the geometry of the machine, that of poses, "
    "they are middle_m + zero_m + scale (q - middle_m), with the values of `controller`.",
    "Comma separated, decimal points, LF line ends, one header line.",
)


def sidecar(
    config: Config,
    machine: Machine,
    samples: TrajectorySamples,
    usage: Usage,
    columns: Iterable[TrajectoryColumn] = TRAJECTORY_COLUMNS,
    interpolated: Iterable[Interpolation] = (),
) -> dict[str, Any]:
    """Describe a sampled trajectory: columns, period, duration, limits and their usage.

    Usage is the largest fraction of each limit, a list in the order of the actuators (of the links for their forces),
    null where there is no limit. `interpolation` says what a controller makes of the rows by its own polynomials: how
    far that is from the motion, the parts of the limits between rows, and what jumps at them. All values are plain
    (dictionaries, lists, texts, numbers), ready for JSON.
    """
    units = controller_units(config.machine)
    return {
        "name": config.name,
        "config_sha256": config_sha256(config),
        "period_s": samples.period_s,
        "duration_s": samples.duration_s,
        "samples": len(samples),
        "conventions": list(_CONVENTIONS),
        "columns": [{"name": row.name, "unit": row.unit, "meaning": row.meaning} for row in columns],
        "limits": _limits(machine, usage.quantities, units),
        "controller": {
            actuator: {"middle_m": middle, "zero_m": zero, "scale": scale}
            for actuator, middle, zero, scale in zip(
                ACTUATORS, units.middles_m.tolist(), units.zeros_m.tolist(), units.scales.tolist(), strict=True
            )
        },
        "shared_limits": {
            quantity.key: _limit(quantity.limit(machine), 0)
            for quantity in usage.quantities
            if quantity.subjects != ACTUATORS
        },
        "usage": {
            quantity.name: usage.fractions[quantity.name].tolist() if quantity.name in usage.fractions else None
            for quantity in usage.quantities
        },
        "interpolation": interpolation_section(interpolated),
    }


def _limits(machine: Machine, quantities: Quantities, units: ControllerUnits) -> dict[str, dict[str, Any]]:
    """List the limits of each actuator: positions (travel or stroke) and quantities of its motion; null: no limit.

    A force limit that depends on the sign is {"push": ..., "pull": ...}.
    """
    own = {quantity.key: quantity.limit(machine) for quantity in quantities if quantity.subjects == ACTUATORS}
    positions = units.to_controller(machine.actuator_limits_m.T).T.tolist()
    return {
        actuator: {
            "column": column,
            "position_m": positions[k],
            **{key: _limit(limit, k) for key, limit in own.items()},
        }
        for k, (actuator, column) in enumerate(zip(ACTUATORS, POSITIONS, strict=True))
    }


def _limit(limit: FloatArray, subject: int) -> float | dict[str, float | None] | None:
    """Return the limit of a subject: one number, or push and pull where they differ."""
    push, pull = (float(side) if math.isfinite(side) else None for side in both_sides(limit)[:, subject].tolist())
    return push if push == pull else {"push": push, "pull": pull}
