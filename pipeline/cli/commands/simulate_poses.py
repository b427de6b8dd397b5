"""The command that simulates what a calibration is made from: static poses, as a tracker sees them."""

from collections.abc import Callable
from pathlib import Path
from typing import Annotated

import typer

from pipeline.cli.console import messages_console
from pipeline.cli.motions.driven import DrivenBack, DrivenPeriod, DrivenSpeed, GeometryOption, driven_motion
from pipeline.cli.motions.reflector_options import (
    FirstReflector,
    SecondReflector,
    ThirdReflector,
    reflector_places,
)
from pipeline.cli.motions.simulated_file import check_simulated, write_simulated, written_beside
from pipeline.cli.options import ConfigArgument
from pipeline.cli.output import refuse_same
from pipeline.errors import UsageError


def simulate_poses(
    config_file: ConfigArgument,
    first: FirstReflector = None,
    second: SecondReflector = None,
    third: ThirdReflector = None,
    output: Annotated[
        Path | None,
        typer.Option("--output", metavar="FILE", readable=False, help="Where to write to. Default: stdout."),
    ] = None,
    poses: Annotated[int, typer.Option("--poses", metavar="N", min=1, max=10_000, help="Number of poses.")] = 40,
    at: Annotated[
        Path | None,
        typer.Option(
            "--at",
            metavar="FILE",
            help="Measure the poses of this table instead, as calibrate --next-output or tour writes it.",
        ),
    ] = None,
    noise_m: Annotated[
        float,
        typer.Option("--noise", metavar="M", min=0.0, max=0.1, help="Standard deviation of each coordinate in metres."),
    ] = 5e-5,
    geometry_m: GeometryOption = 2e-4,
    scales: Annotated[
        float, typer.Option("--scales", metavar="STD", min=0.0, max=0.01, help="Standard deviation of encoder scales.")
    ] = 1e-4,
    rails_rad: Annotated[
        float,
        typer.Option("--rails", metavar="RAD", min=0.0, max=0.01, help="Standard deviation of the slopes of rails."),
    ] = 0.0,
    outliers: Annotated[
        float, typer.Option("--outliers", metavar="PART", min=0.0, max=0.5, help="Part of the points 50 mm off.")
    ] = 0.0,
    seed: Annotated[int, typer.Option("--seed", metavar="N", min=0, help="Seed of the random numbers.")] = 0,
    run: Annotated[
        Path | None,
        typer.Option("--run", metavar="RUN", help="Measure the motion of this run instead, once per period."),
    ] = None,
    clock_s: Annotated[
        float,
        typer.Option(
            "--clock", metavar="S", min=-2.0, max=2.0, help="With --run: by how much the clock of the tracker is late."
        ),
    ] = 0.0,
    speed: DrivenSpeed = None,
    period_s: DrivenPeriod = None,
    back: DrivenBack = False,
) -> None:
    """Simulate what a tracker sees of a slightly inaccurate machine that stands still at many poses.

    Joints, rails, lengths, reflectors, and zeros and scales of encoders have
    random errors, drawn once; the tracker stands somewhere. Poses are in all
    working modes, with a kappa of at most 25, on the side of the Type-II
    singularities where the start of the task is. The file is one that
    `calibrate` reads.

    --at FILE fills in a table of poses to measure. The same --seed and
    --poses are the same machine and tracker, whatever table it is.

    With --run the machine is measured while it drives the motion of a run;
    its actuators are exactly where they are commanded. It is the machine that
    static poses with the same seed and number of poses are of.
    """
    from pipeline.calibrate import StaticSetting, simulate_motion, simulate_static
    from pipeline.calibrate.data.reading import read_places
    from pipeline.calibrate.data.simulated import static_columns
    from pipeline.config.file import load_config
    from pipeline.export.csv import format_csv

    beside = None if output is None else check_simulated(output, config_file)
    if at is not None and outliers:
        raise UsageError("--outliers goes without --at: leave out one of the two")
    if at is not None and run is not None:
        raise UsageError("--run goes without --at: leave out one of the two")
    refuse_same(output, at, "--output and --at")
    reflectors_m = reflector_places(first, second, third)
    setting = StaticSetting(poses, geometry_m, scales, rails_rad, noise_m, outliers, seed)
    config = load_config(config_file)
    motion = driven_motion(run, speed, period_s, back, clock_s)
    if motion is None:
        simulated = simulate_static(config, reflectors_m, setting)
    else:
        simulated = simulate_motion(config, reflectors_m, motion, setting, clock_s)
    poses_seen = simulated.poses if at is None else simulated.measure(*read_places(at))
    text = format_csv(static_columns(poses_seen))
    if output is None:
        typer.echo(text, nl=False)
        return
    truth = simulated.truth
    write_simulated(
        output,
        beside,
        text,
        {
            "config": str(config_file),
            "reflectors_m": reflectors_m,
            "setting": setting,
            "truth": dict(zip(truth.parameters.names, truth.values(), strict=True)),
            "tracker": {"rotation": truth.rotation, "translation_m": truth.translation_m},
            "outliers": simulated.is_outlier if at is None else [],
            **({} if run is None else {"run": str(run), "clock_s": clock_s}),
        },
    )
    kind = "poses" if run is None else "rows of a motion"
    what = f"{output}: {len(poses_seen):,} {kind} of a simulated measurement"
    messages_console().print(what + written_beside(beside), soft_wrap=True)


COMMANDS: tuple[tuple[Callable[..., None], tuple[str, ...]], ...] = (
    (
        simulate_poses,
        (
            "gantry-tau simulate-poses cell.yaml --reflector-1 0 .1 .05 --reflector-2 0 .4 .05 --output poses.csv",
            "gantry-tau simulate-poses cell.yaml --reflector-1 0 .1 .05 --reflector-2 0 .4 .05 --at tour/poses.csv",
            "gantry-tau simulate-poses cell.yaml --reflector-1 0 .1 .05 --outliers 0.02 --rails 0.0001 > poses.csv",
            "gantry-tau simulate-poses cell.yaml --run results/cell --clock 0.05 --reflector-1 0 .1 .05 --output m.csv",
        ),
    ),
)
"""The command with its examples."""
