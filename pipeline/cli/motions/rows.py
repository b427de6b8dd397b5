"""What a controller makes of exported rows between them: limits it would exceed, and a motion that exceeds none."""

from typing import TYPE_CHECKING

from pipeline.cli.console import messages_console
from pipeline.errors import UsageError
from pipeline.export.formats import Format

if TYPE_CHECKING:
    from pipeline.config import Config
    from pipeline.retime import Trajectory


def interpolated_by_controller(kind: Format, trajectory: "Trajectory", config: "Config", *, safe: bool) -> "Trajectory":
    """Warn of limits that are exceeded between rows, or give a motion slow enough for all to be kept, and say so.

    Only interpolations by which a format is read count; formats that hold no rows, or leave some out, are not checked.

    Raises
    ------
    UsageError
        When a motion is to be safe in a format without such rows.
    NoSolutionError
        When slowing down does not help.
    """
    if not kind.reader or "tolerance_m" in kind.options:
        if safe:
            raise UsageError(
                f"--safe is about rows, one per period, and {kind} has none.\n  What to change: leave --safe out."
            )
        return trajectory
    from pipeline.retime import interpolations, safe_to_interpolate, sample_trajectory

    period_s, jerk, console = config.retime.period_s, config.retime.jerk, messages_console()
    if safe:
        slower = safe_to_interpolate(trajectory, period_s, jerk=jerk, methods=kind.read_by)
        factor = slower.motion_s / trajectory.motion_s
        console.print(
            f"--safe: the motion takes {slower.motion_s:g} s instead of {trajectory.motion_s:g} s, {factor - 1.0:+.2%}",
            soft_wrap=True,
        )
        return slower
    found = interpolations(trajectory, sample_trajectory(trajectory, period_s), jerk=jerk)
    warnings = [one.warning for one in found if one.method in kind.read_by]
    for warning in filter(None, warnings):
        console.print(f"Warning: {warning}.", soft_wrap=True)
    if any(warnings):
        console.print("  What to change: --safe, a shorter --period, or a --speed below 1.", soft_wrap=True)
    return trajectory
