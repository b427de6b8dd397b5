"""Commands that run stages: run, route, refine, retime."""

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from pipeline.cli.console import messages_console
from pipeline.cli.options import (
    ConfigArgument,
    ForceOption,
    NoWhyNotOption,
    OutOption,
    SpeedOption,
    UnprovenOption,
    VerboseOption,
    load_task,
    specs_of,
)
from pipeline.cli.run_stages import run_stages
from pipeline.config.choices import Formulation
from pipeline.errors import UsageError
from pipeline.stage import STAGES, Stage

if TYPE_CHECKING:
    from pipeline.config import Config
    from pipeline.run import RunOptions


def run(
    context: typer.Context,
    config: ConfigArgument,
    out: OutOption = None,
    first: Annotated[
        Stage | None,
        typer.Option("--from", help="Run this stage and later ones in any case; earlier results must be up to date."),
    ] = None,
    last: Annotated[Stage | None, typer.Option("--to", help="Stop after this stage.")] = None,
    speed: SpeedOption = None,
    force: ForceOption = False,
    verbose: VerboseOption = False,
    no_why_not: NoWhyNotOption = False,
    unproven: UnprovenOption = False,
    pdf: Annotated[
        bool, typer.Option("--pdf", help="Write the figures as PDF, too, as figures.pdf of CONFIG does.")
    ] = False,
) -> None:
    """Run everything: regions, route, path, certificate, trajectory, figures and report.

    Only stages whose part of CONFIG, or whose earlier results, have changed
    are run; the others are kept. Results that are replaced move to
    DIR/superseded, which may be deleted at any time; details of a failed
    stage are in DIR/failed.
    """
    from pipeline.run import RunOptions

    options = RunOptions(first, last or STAGES[-1], force, verbose, not no_why_not, unproven)
    _run(context, config, out, options, speed, pdf)


def route(
    context: typer.Context,
    config: ConfigArgument,
    out: OutOption = None,
    force: ForceOption = False,
    verbose: VerboseOption = False,
    no_why_not: NoWhyNotOption = False,
    formulation: Annotated[
        Formulation | None,
        typer.Option(help="The program to solve. Default: route.formulation of CONFIG; core is the fast one."),
    ] = None,
    alternatives: Annotated[
        int,
        typer.Option(
            metavar="K", min=1, max=10, help="The K best routes, each in a folder of its own: DIR, DIR-2, ..."
        ),
    ] = 1,
    write_mps: Annotated[
        Path | None,
        typer.Option(
            "--write-mps",
            metavar="FILE",
            readable=False,
            help="Write the paper or compact program and do not solve it.",
        ),
    ] = None,
) -> None:
    """Stage one: find the regions, and the best route through them (a mixed-integer program).

    The route is proven optimal over all admitted moves between regions, or
    proven not to exist. When route.time_limit_s ends the search first, the
    best route so far is kept with its bound and gap, and the exit code is 1.
    Alternatives differ from each better route by
    route.alternative_distance grid steps, or by their working modes.
    """
    if alternatives > 1 and write_mps is not None:
        raise UsageError("--write-mps goes with --alternatives 1: each alternative needs the better routes first")
    chosen = _with_formulation(load_task(config), formulation)
    if write_mps is not None:
        from pipeline.cli.program_file import write_program

        write_program(chosen, write_mps, messages_console())
        return
    from pipeline.run import RunOptions

    options = RunOptions(last=Stage.ROUTE, force=force, verbose=verbose, why_not=not no_why_not)
    if alternatives > 1:
        from pipeline.cli.alternatives import plan_alternatives
        from pipeline.config.file import results_folder

        plan_alternatives(chosen, out or results_folder(chosen.name), alternatives, options, specs_of(context))
        return
    run_stages(config, chosen, out, options, specs_of(context))


def refine(
    context: typer.Context,
    config: ConfigArgument,
    out: OutOption = None,
    force: ForceOption = False,
    verbose: VerboseOption = False,
    unproven: UnprovenOption = False,
) -> None:
    """Stage two: smooth the route into a path of splines in actuator space (a nonlinear program).

    Runs stage one first, unless its result in DIR is up to date.
    """
    from pipeline.run import RunOptions

    _run(context, config, out, RunOptions(last=Stage.REFINE, force=force, verbose=verbose, unproven=unproven))


def retime(
    context: typer.Context,
    config: ConfigArgument,
    out: OutOption = None,
    speed: SpeedOption = None,
    force: ForceOption = False,
    verbose: VerboseOption = False,
    unproven: UnprovenOption = False,
) -> None:
    """Stage three: time the path within all limits, and write trajectory.csv and that of the way back.

    Runs stages one and two and the proof first, unless their results in DIR
    are up to date: other limits or another period cost seconds.
    """
    from pipeline.run import RunOptions

    _run(context, config, out, RunOptions(last=Stage.RETIME, force=force, verbose=verbose, unproven=unproven), speed)


def _run(
    context: typer.Context,
    path: Path,
    out: Path | None,
    options: "RunOptions",
    speed: float | None = None,
    pdf: bool = False,
) -> None:
    from pipeline.run.reading import with_pdf, with_retime

    config = with_retime(load_task(path), speed=speed)
    run_stages(path, with_pdf(config) if pdf else config, out, options, specs_of(context))


def _with_formulation(config: "Config", formulation: Formulation | None) -> "Config":
    if formulation is None:
        return config
    from pipeline.config.file import parse_config

    data = config.model_dump()
    data["route"]["formulation"] = formulation
    return parse_config(data)


COMMANDS: tuple[tuple[Callable[..., None], tuple[str, ...]], ...] = (
    (
        run,
        (
            "gantry-tau run configs/agder.yaml",
            "gantry-tau run configs/agder.yaml --out /tmp/try --to route    (regions and route only)",
            "gantry-tau run configs/agder.yaml --from retime    (path in time and figures, in any case)",
        ),
    ),
    (
        route,
        (
            "gantry-tau route configs/quick.yaml -v",
            "gantry-tau route configs/quick.yaml --alternatives 3",
            "gantry-tau route configs/tiny.yaml --formulation paper    (the paper's own program, for small grids)",
            "gantry-tau route configs/tiny.yaml --formulation paper --write-mps paper.mps",
        ),
    ),
    (refine, ("gantry-tau refine configs/quick.yaml",)),
    (retime, ("gantry-tau retime configs/quick.yaml", "gantry-tau retime configs/quick.yaml --speed 0.3")),
)
"""Every command with its examples."""
