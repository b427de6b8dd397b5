"""Trip limits of controllers, from how far the actuators may be off the path: for ROS 2 and for LinuxCNC.

What is proven is how far they may be off the path, whatever the time. Of that, what the controller's own polynomials
between the points of the export are off is taken away. Where a controller trips, the drives still have to brake.
"""

import json
import math

from pipeline.arrays import FloatArray
from pipeline.export.formats import LengthUnit
from pipeline.export.request import ExportRequest
from pipeline.machine.geometry import ACTUATORS

_STEP_M = 1e-7
"""Limits are rounded down to whole steps."""
_STOPPED_MPS = 0.01
_GOAL_TIME_S = 1.0


def trip_limits(request: ExportRequest) -> FloatArray | None:
    """Compute the trip limits (5,) in metres; None without a proof, or where nothing of it is left."""
    if request.tube is None:
        return None
    left = request.tube.errors_m - (0.0 if request.deviation_m is None else request.deviation_m)
    return left if (left >= _STEP_M).all() else None


def format_ros2_constraints(request: ExportRequest) -> str | None:
    """Write parameters of joint_trajectory_controller: tolerances of each joint on the way and at the goal.

    On the way 0 would mean that nothing is checked, and as `goal_time` that the goal is waited for without end.
    """
    limits = trip_limits(request)
    if limits is None:
        return None
    lines = [
        *_heading(request),
        "# Parameters of a joint_trajectory_controller of this name, beside those that it has: for the spawner of",
        "# controller_manager, --param-file.",
        "joint_trajectory_controller:",
        "  ros__parameters:",
        "    constraints:",
        f"      stopped_velocity_tolerance: {_STOPPED_MPS}",
        f"      goal_time: {_GOAL_TIME_S}",
    ]
    for name, limit in zip(request.joint_names, limits.tolist(), strict=True):
        shown = _rounded(limit, 1.0)
        lines += [f"      {json.dumps(name)}:", f"        trajectory: {shown}", f"        goal: {shown}"]
    return "\n".join(lines) + "\n"


def format_linuxcnc_ini(request: ExportRequest) -> str | None:
    """Write FERROR and MIN_FERROR of each joint, in the unit of the export.

    LinuxCNC allows FERROR at a joint's largest velocity and less below, but never less than MIN_FERROR: both are the
    same, so that the limit is the same at any velocity.
    """
    limits = trip_limits(request)
    if limits is None:
        return None
    unit = request.options.length
    lines = [
        *_heading(request),
        f"# Put these lines into the sections of the machine's INI file; in {_UNITS[unit]}, as the positions are.",
    ]
    rows = zip(ACTUATORS, request.joint_names, limits.tolist(), strict=True)
    for k, (actuator, joint, limit) in enumerate(rows):
        shown = _rounded(limit, unit.metres)
        lines += [
            "",
            f"[JOINT_{k}]",
            f"# {joint}" if joint == actuator else f"# {actuator}: {joint}",
            f"FERROR = {shown}",
            f"MIN_FERROR = {shown}",
        ]
    return "\n".join(lines) + "\n"


_UNITS = {LengthUnit.M: "metres", LengthUnit.MM: "millimetres"}


def _heading(request: ExportRequest) -> list[str]:
    assert request.tube is not None, "there are limits"
    off = 0.0 if request.deviation_m is None else float(request.deviation_m.max())
    between = [f"# Taken away: {_length(off)}, how far polynomials between the points are off at most."] if off else []
    return [
        f"# Proven: with every actuator up to {1e3 * request.tube.errors_m.min():.4g} mm off the path at a time,",
        f"# {request.tube.meaning}.",
        *between,
        "# What the drives still move while they brake after a trip has to be taken away, too.",
    ]


def _length(length_m: float) -> str:
    """Write a length in the unit in which it is no tiny fraction."""
    unit, metres = next(((unit, m) for unit, m in (("mm", 1e-3), ("um", 1e-6)) if length_m >= 0.1 * m), ("nm", 1e-9))
    return f"{length_m / metres:.2g} {unit}"


def _rounded(limit_m: float, unit_m: float) -> str:
    decimals = round(-math.log10(_STEP_M / unit_m))
    return f"{math.floor(limit_m / _STEP_M) * _STEP_M / unit_m:.{decimals}f}"
