"""The command that finds stable gains for the drives of a run."""

from collections.abc import Callable
from typing import TYPE_CHECKING, Annotated

import typer

from pipeline.cli.console import messages_console
from pipeline.cli.motions.driven import DrivenPeriod, DrivenSpeed, DrivesOption, driven, planned, with_drives
from pipeline.cli.options import RunArgument
from pipeline.cli.output import text_table
from pipeline.errors import NoSolutionError

if TYPE_CHECKING:
    from pipeline.simulate.tuning import Poles, Tuning


def tune(
    run: RunArgument,
    damping: Annotated[
        float,
        typer.Option("--damping", metavar="D", min=0.01, max=0.95, help="Least damping ratio of all frozen poles."),
    ] = 0.2,
    speed: DrivenSpeed = None,
    period_s: DrivenPeriod = None,
    drives: DrivesOption = None,
) -> None:
    """Find gains of the drives that are stable all along the motion of a run, there and back.

    At 400 instants each way the machine is frozen: its mass, and what
    gravity and velocities do to it, as the drives see them. Printed is the
    section drives with the largest position gain for which all poles of the
    sampled loop have the damping; before and after are on stderr. Exits with
    1 if no gains have it. Frozen poles are no proof for a motion: simulate it.
    """
    import yaml

    trajectory, config = driven(run, speed, period_s, False)
    config = config if drives is None else with_drives(config, drives)
    from pipeline.progress import Monitor
    from pipeline.simulate import build_drives
    from pipeline.simulate.tuning import tune_drives

    machine = trajectory.path.machine
    with messages_console().status("tuning") as status:

        def progress(message: str, fraction: float | None = None) -> None:
            status.update(message)

        motion = planned(trajectory, config, period_s)
        tuning = tune_drives(machine, build_drives(config.drives, machine), motion, damping, Monitor(progress))
    rows = [_cells("as configured", tuning.before), _cells("tuned", tuning.after)]
    header = ("gains", "least damping", "driven", "at s of the way there", "rightmost pole 1/s", "unstable instants")
    messages_console().print(
        text_table(f"{run}: frozen-time poles, controllers at {motion.period_s:g} s", header, rows)
    )
    _require_found(tuning)
    data = config.drives.with_gains(tuning.gains.keys("carts"), tuning.gains.keys("telescopes"))
    typer.echo(_comment(tuning) + yaml.safe_dump({"drives": data}, sort_keys=False), nl=False)


def _cells(name: str, poles: "Poles") -> tuple[str, ...]:
    worst = int(poles.damping.argmin())
    return (
        name,
        f"{poles.damping[worst]:.3f}",
        _way(poles, worst),
        f"{poles.t_s[worst]:.3f}",
        f"{poles.rightmost_per_s.max():+.2f}",
        f"{int((poles.rightmost_per_s > 0.0).sum())} of {len(poles.t_s)}",
    )


def _way(poles: "Poles", row: int) -> str:
    """Name the way of a row: those of the way back follow those of the way there."""
    return "there" if row < len(poles.t_s) // 2 else "back"


def _comment(tuning: "Tuning") -> str:
    worst = int(tuning.after.damping.argmin())
    return (
        f"# damping of all frozen poles at least {tuning.after.damping[worst]:.3f} (asked for: {tuning.wanted:g}), "
        f"least at {tuning.after.t_s[worst]:.3f} s of the way there, driven {_way(tuning.after, worst)}\n"
    )


def _require_found(tuning: "Tuning") -> None:
    """Raise where no gains have the damping.

    Raises
    ------
    NoSolutionError
        With the best that was found, and what to change.
    """
    if tuning.found:
        return
    best, gains = float(tuning.after.damping.min()), tuning.gains
    nearest = (
        f"the largest damping found is {best:.3f}, with a position gain of {gains.position_gain_per_s:g}/s, velocity "
        f"gains of {gains.carts_nspm:g} Ns/m (carts) and {gains.telescopes_nspm:g} Ns/m (telescopes) and an integral "
        f"time of {gains.integral_time_s:.3g} s"
    )
    lower = f"Ask for less (--damping {_rounded_down(best):g}), or use" if best > 0.02 else "Use"
    raise NoSolutionError(
        "tune",
        f"no gains have a damping of {tuning.wanted:g} along this motion; {nearest}",
        f"{lower} a shorter controller period (--period), less force lag or delay, or drive slower (--speed).",
        {"damping": best},
    )


def _rounded_down(value: float) -> float:
    return int(100.0 * value) / 100.0


COMMANDS: tuple[tuple[Callable[..., None], tuple[str, ...]], ...] = (
    (
        tune,
        (
            "gantry-tau tune results/agder > tuned.yaml; gantry-tau simulate results/agder --drives tuned.yaml",
            "gantry-tau tune results/agder --damping 0.1 --speed 0.5",
        ),
    ),
)
"""The command with its examples."""
