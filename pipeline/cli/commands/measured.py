"""Commands for measurements: compare a measured motion with the commanded one, and simulate a measurement of it."""

from collections.abc import Callable
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from pipeline.cli.console import messages_console, results_console
from pipeline.cli.motions.driven import DrivenBack, DrivenPeriod, DrivenSpeed, GeometryOption, driven
from pipeline.cli.motions.simulated_file import check_simulated, write_simulated, written_beside
from pipeline.cli.options import RunArgument
from pipeline.cli.output import check_picture, save_picture, text_table

if TYPE_CHECKING:
    from pipeline.measured import MeasurementComparison, Reflectors

_Point = tuple[float, float, float]
_First = Annotated[
    _Point, typer.Option("--reflector-1", metavar="X Y Z", help="First reflector in the platform frame in metres.")
]
_Second = Annotated[_Point, typer.Option("--reflector-2", metavar="X Y Z", help="Second reflector.")]
_Noise = Annotated[
    float,
    typer.Option("--noise", metavar="M", min=0.0, max=0.1, help="Standard deviation of each coordinate in metres."),
]
_FIRST: _Point = (0.0, 0.10, 0.05)
_SECOND: _Point = (0.0, 0.40, 0.05)
_NOISE_M = 5e-5


def measured(
    run: RunArgument,
    measurement: Annotated[Path, typer.Argument(metavar="FILE", help="The CSV file with the measurement.")],
    first: _First = _FIRST,
    second: _Second = _SECOND,
    noise_m: _Noise = _NOISE_M,
    speed: DrivenSpeed = None,
    period_s: DrivenPeriod = None,
    back: DrivenBack = False,
    as_json: Annotated[bool, typer.Option("--json", help="Print JSON, unrounded, in metres and radians.")] = False,
    picture: Annotated[
        Path | None,
        typer.Option(
            "--picture", metavar="FILE", readable=False, help="Draw the motion over time: .png, .pdf or .svg."
        ),
    ] = None,
) -> None:
    """Compare a measured motion with the commanded one: errors of x, y, z, rx, rz, with error bars.

    The file has a column t_s, counted from the start of the motion, and the
    positions of two reflectors on the platform (x1_m, y1_m, z1_m, x2_m,
    y2_m, z2_m), or the pose (x_m, y_m, z_m, rx_rad, rz_rad), which comes
    without error bars. From reflectors rx and rz are estimated with ry as
    commanded; error bars are those of the noise. If the motion was exported
    with --speed, --period or --back, give them here too.

    Values are separated by commas, semicolons or tabs, decimals by points or
    commas. Lines above the header, of units, blank ones, comments (#), and
    rows with gaps (empty, ---, NaN, #N/A) are skipped, and counted on stderr
    and in the JSON with their lines; anything else is refused.
    """
    check_picture(picture, run)
    from pipeline.measured import compare_measurement, read_measurement

    reflectors = _reflectors(first, second, noise_m)
    trajectory, _ = driven(run, speed, period_s, back)
    given = read_measurement(measurement, trajectory.duration_s)
    assert given.account is not None
    messages_console().print(given.account.message(), soft_wrap=True)
    commanded = trajectory.pose(given.t_s.clip(0.0, trajectory.duration_s))
    comparison = compare_measurement(given, commanded, reflectors)
    way = f"the way back of {run}" if back else f"{run}"
    _show(comparison, as_json, f"{measurement} against {way}, {len(given.t_s):,} rows")
    if picture is not None:
        from pipeline.figures.time.measured import measured_figure

        save_picture(measured_figure(comparison), picture)
        messages_console().print(f"{picture}: commanded and measured over time, with errors", soft_wrap=True)


def _show(comparison: "MeasurementComparison", as_json: bool, title: str) -> None:
    from pipeline.artifacts import json_bytes
    from pipeline.measured.comparison import TABLE_HEADER, error_rows, table_cells

    rows = error_rows(comparison)
    if as_json:
        units = {"rx": "rad", "rz": "rad"}
        assert comparison.account is not None
        read = comparison.account.as_json()
        table = [{**asdict(row), "unit": units.get(row.quantity, "m"), **read} for row in rows]
        typer.echo(json_bytes(table), nl=False)
        return
    results_console().print(text_table(title, TABLE_HEADER, table_cells(rows), (0, 1)))


def simulate_measurement(
    run: RunArgument,
    output: Annotated[
        Path | None,
        typer.Option("--output", metavar="FILE", readable=False, help="Where to write to. Default: stdout."),
    ] = None,
    first: _First = _FIRST,
    second: _Second = _SECOND,
    noise_m: _Noise = _NOISE_M,
    geometry_m: GeometryOption = 2e-4,
    seed: Annotated[int, typer.Option("--seed", metavar="N", min=0, help="Seed of the random numbers.")] = 0,
    outliers: Annotated[
        float, typer.Option("--outliers", metavar="PART", min=0.0, max=0.5, help="Part of the points 50 mm off.")
    ] = 0.0,
    clock_s: Annotated[
        float,
        typer.Option("--clock", metavar="S", min=-1.0, max=1.0, help="By how much the times of the tracker are late."),
    ] = 0.0,
    speed: DrivenSpeed = None,
    period_s: DrivenPeriod = None,
    back: DrivenBack = False,
) -> None:
    """Simulate what a tracker measures of two reflectors while a slightly inaccurate machine drives the trajectory.

    Joints, rails, lengths and zeros of telescopes have random errors, drawn
    once; every coordinate of every reflector has noise. The same seed gives
    the same file, with one row per period. Its actuators are exactly where
    they are commanded: what drives and controllers add is `simulate`. Poses
    at which the machine stands still are `simulate-poses`.
    """
    from pipeline.export.csv import format_csv
    from pipeline.measured import SimulationSetting, measurement_columns
    from pipeline.measured import simulate_measurement as simulate
    from pipeline.retime import sample_trajectory, whole_periods

    beside = None if output is None else check_simulated(output, run)
    reflectors, setting = _reflectors(first, second, noise_m), SimulationSetting(geometry_m, seed, outliers)
    trajectory, config = driven(run, speed, period_s, back)
    samples = sample_trajectory(trajectory, config.retime.period_s)
    q_m, pose = samples.q_m, samples.pose
    if clock_s != 0.0:
        driven_at = whole_periods(trajectory, config.retime.period_s)
        then = (samples.t_s - clock_s).clip(0.0, samples.duration_s)
        q_m, pose = driven_at.q(then), driven_at.pose(then)
    positions = simulate(trajectory.path.machine, q_m, pose, reflectors, setting)
    text = format_csv(measurement_columns(samples.t_s, positions))
    if output is None:
        typer.echo(text, nl=False)
        return
    facts: dict[str, Any] = {
        "run": str(run),
        "speed": 1.0 if speed is None else speed,
        "period_s": config.retime.period_s,
        "back": back,
        "clock_s": clock_s,
        "reflectors": reflectors,
        "setting": setting,
    }
    write_simulated(output, beside, text, facts)
    what = f"{output}: {len(samples):,} rows of a simulated measurement"
    messages_console().print(what + written_beside(beside), soft_wrap=True)


def _reflectors(first: _Point, second: _Point, noise_m: float) -> "Reflectors":
    import numpy as np

    from pipeline.measured import Reflectors

    return Reflectors(np.array([first, second]), noise_m)


COMMANDS: tuple[tuple[Callable[..., None], tuple[str, ...]], ...] = (
    (
        measured,
        (
            "gantry-tau measured results/agder tracker.csv --picture tracker.png",
            "gantry-tau measured results/agder tracker.csv --reflector-1 0 0.1 0.05 --reflector-2 0 0.4 0.05",
            "gantry-tau measured results/agder tracker.csv --noise 0.00003 --json",
            "gantry-tau measured results/agder slow.csv --speed 0.3",
            "gantry-tau measured results/agder back.csv --back",
        ),
    ),
    (
        simulate_measurement,
        (
            "gantry-tau simulate-measurement results/agder --output simulated.csv",
            "gantry-tau simulate-measurement results/agder --geometry 0 --noise 0.0001 --seed 7 > noise.csv",
        ),
    ),
)
"""Every command with its examples."""
