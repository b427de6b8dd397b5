"""The command that simulates the machine with its drives while it follows the motion of a run."""

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from pipeline.cli.console import messages_console, results_console
from pipeline.cli.motions.driven import (
    DrivenBack,
    DrivenPeriod,
    DrivenSpeed,
    DrivesOption,
    GeometryOption,
    driven,
    planned,
    with_drives,
)
from pipeline.cli.motions.simulated_file import check_simulated, write_simulated, written_beside
from pipeline.cli.options import RunArgument
from pipeline.cli.output import check_picture, save_picture, text_table
from pipeline.errors import NoSolutionError

if TYPE_CHECKING:
    from pipeline.config import Config
    from pipeline.retime import Trajectory
    from pipeline.simulate import Deviations, Simulation
    from pipeline.simulate.tube import TubeCheck

_FIGURES = ("", "_following", "_forces")
"""What is added to the name of a picture for each of the three figures."""


def simulate(
    run: RunArgument,
    back: DrivenBack = False,
    speed: DrivenSpeed = None,
    period_s: DrivenPeriod = None,
    drives: DrivesOption = None,
    geometry_m: GeometryOption = 0.0,
    seed: Annotated[
        int, typer.Option("--seed", metavar="N", min=0, help="Seed of the deviations of the geometry.")
    ] = 0,
    mass_error: Annotated[
        float,
        typer.Option(
            "--mass-error", metavar="PERCENT", min=-90.0, max=900.0, help="By how much all masses are larger."
        ),
    ] = 0.0,
    load_kg: Annotated[
        float, typer.Option("--load", metavar="KG", min=0.0, max=10_000.0, help="A load at the TCP besides the plan's.")
    ] = 0.0,
    output: Annotated[
        Path | None,
        typer.Option(
            "--output", metavar="FILE", readable=False, help="Write the motion as CSV, which `measured` reads."
        ),
    ] = None,
    picture: Annotated[
        Path | None,
        typer.Option(
            "--picture",
            metavar="FILE",
            readable=False,
            help="Draw errors (FILE), following errors (FILE_following) and forces (FILE_forces): .png, .pdf or .svg.",
        ),
    ] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print JSON, unrounded, in metres and radians.")] = False,
) -> None:
    """Simulate the machine with its drives and their controllers while it follows the motion of a run.

    The real machine is the model, or one with a slightly wrong geometry,
    wrong masses or an unknown load; the controllers know only the model.
    Drives are those of the section drives of the run's configuration, whose
    defaults are assumed. Shown are errors of the pose, following errors
    against what trips the drives, forces against plan and limits, and
    working modes with their times.

    Controllers run at --period; by default at the run's period or, above
    1 ms, the largest whole part of it that is at most 1 ms. The machine
    stands for a second before and after the motion. Exits with 1 if a drive
    trips, the machine is lost, or ends elsewhere.
    """
    beside = None if output is None else check_simulated(output, run)
    pictures = [] if picture is None else [picture.with_stem(picture.stem + what) for what in _FIGURES]
    for path in pictures:
        check_picture(path, run)
    from pipeline.run.reading import open_tubes
    from pipeline.simulate import Deviations
    from pipeline.simulate.tube import check_tube

    trajectory, config = driven(run, speed, period_s, back)
    config = config if drives is None else with_drives(config, drives)
    deviations = Deviations(geometry_m, seed, mass_error / 100.0, load_kg)
    simulation = _simulate(trajectory, config, deviations, period_s)
    facts: dict[str, Any] = {
        "run": str(run),
        "speed": 1.0 if speed is None else speed,
        "period_s": simulation.motion.period_s,
        "back": back,
        "setting": deviations,
        "configured": config.drives.model_dump(mode="json"),
    }
    _show(simulation, [check_tube(simulation, tube) for tube in open_tubes(run)], facts, as_json)
    if output is not None:
        _write(simulation, output, beside, facts)
    if pictures:
        _draw(simulation, pictures)
    _require_arrival(simulation)


def _simulate(
    trajectory: "Trajectory", config: "Config", deviations: "Deviations", period_s: float | None
) -> "Simulation":
    from pipeline.progress import Monitor
    from pipeline.simulate import build_drives, build_plant, simulate_motion

    machine = trajectory.path.machine
    plant = build_plant(machine, deviations)
    with messages_console().status("simulating") as status:

        def progress(message: str, fraction: float | None = None) -> None:
            status.update(message if fraction is None else f"{message}: {fraction:.0%}")

        motion = planned(trajectory, config, period_s)
        return simulate_motion(
            machine, plant, build_drives(config.drives, machine), motion, monitor=Monitor(progress, False)
        )


def _show(simulation: "Simulation", checks: "list[TubeCheck]", facts: dict[str, Any], as_json: bool) -> None:
    from pipeline.artifacts import json_bytes
    from pipeline.artifacts.layout import CONFIG
    from pipeline.simulate.table import (
        determinant_text,
        simulation_data,
        simulation_tables,
        trip_text,
        tube_table,
        tube_text,
    )

    if as_json:
        typer.echo(json_bytes({**facts, **simulation_data(simulation, checks)}), nl=False)
        return
    title = f"{'the way back of ' if facts['back'] else ''}{facts['run']}"
    for table in [*simulation_tables(simulation), *(tube_table(simulation, one) for one in checks[:1])]:
        results_console().print(
            text_table(f"{title}: {table.title}", table.header, table.rows, tuple(range(table.words)))
        )
    results_console().print(determinant_text(simulation), soft_wrap=True)
    for check in checks:
        results_console().print(tube_text(simulation, check), soft_wrap=True)
    if (late := trip_text(simulation, checks)) is not None:
        results_console().print(late, soft_wrap=True)
    if not checks:
        results_console().print(
            f"no tube about the path is proven: gantry-tau certify {Path(facts['run']) / CONFIG} --out {facts['run']} "
            "--following",
            soft_wrap=True,
        )
    verdict = simulation.verdict
    results_console().print(f"{verdict.ending} {verdict.when}: {verdict.reason}", soft_wrap=True)


def _write(simulation: "Simulation", output: Path, beside: Path | None, facts: dict[str, Any]) -> None:
    from pipeline.export.csv import format_csv
    from pipeline.simulate.table import simulation_columns

    write_simulated(output, beside, format_csv(simulation_columns(simulation)), facts)
    text = f"{output}: {len(simulation):,} rows of a simulated motion{written_beside(beside)}"
    messages_console().print(text, soft_wrap=True)


def _draw(simulation: "Simulation", pictures: list[Path]) -> None:
    from pipeline.figures.time.simulated import errors_figure, following_figure, forces_figure

    for path, draw in zip(pictures, (errors_figure, following_figure, forces_figure), strict=True):
        save_picture(draw(simulation), path)
    messages_console().print(f"{', '.join(map(str, pictures))}: errors, following errors, forces", soft_wrap=True)


def _require_arrival(simulation: "Simulation") -> None:
    """Raise where the machine does not stand at the goal.

    Raises
    ------
    NoSolutionError
        With the reason, and what to change.
    """
    from pipeline.simulate.rows import drive_rows

    verdict = simulation.verdict
    if verdict.arrived:
        return
    advice = (
        "Take gains that are stable for this machine and path (`gantry-tau tune RUN` prints them, --drives tries "
        "them), or drive slower (--speed)."
    )
    if saturated := [row.drive for row in drive_rows(simulation) if row.saturated_s > 0.0]:
        advice = (
            f"{', '.join(saturated)} gave all the force they have: carry less (--load), allow more (saturation_n in "
            f"drives, or the limits of force in machine.limits), or drive slower (--speed)."
        )
    reason = f"{verdict.when} {verdict.reason}"
    raise NoSolutionError("simulate", reason, advice, {"ending": str(verdict.ending), "t_s": verdict.t_s})


COMMANDS: tuple[tuple[Callable[..., None], tuple[str, ...]], ...] = (
    (
        simulate,
        (
            "gantry-tau simulate results/agder --picture twin.png",
            "gantry-tau simulate results/agder --back --mass-error 5 --load 2 --json",
            "gantry-tau simulate results/agder --geometry 0.0002 --output twin.csv; "
            "gantry-tau measured results/agder twin.csv",
            "gantry-tau tune results/agder > tuned.yaml; gantry-tau simulate results/agder --drives tuned.yaml",
        ),
    ),
)
"""The command with its examples."""
