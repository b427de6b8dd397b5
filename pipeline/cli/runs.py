"""Commands that run stages: run, route, refine, retime."""

import shlex
from collections.abc import Callable
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from pipeline.cli.console import messages_console, results_console
from pipeline.cli.reporter import make_reporter
from pipeline.errors import ConfigError, UsageError
from pipeline.stage import Stage

if TYPE_CHECKING:
    from pipeline.config import Config

_RESULTS = Path("results")


class Formulation(StrEnum):
    """Programs of stage one."""

    CORE = "core"
    COMPACT = "compact"
    PAPER = "paper"


ConfigArgument = Annotated[Path, typer.Argument(metavar="CONFIG", help="The YAML file of machine, task and options.")]
OutOption = Annotated[
    Path | None,
    typer.Option("--out", metavar="DIR", help="Folder of the results. Default: results/<name in CONFIG>."),
]
ForceOption = Annotated[bool, typer.Option("--force", help="Run what is up to date again, too.")]
NoWhyNotOption = Annotated[
    bool,
    typer.Option("--no-why-not", help="Where no route exists, do not look for what stands in the way (minutes)."),
]
SpeedOption = Annotated[
    float | None,
    typer.Option("--speed", metavar="PART", help="Part of the full speed, above 0, at most 1: for a first gentle run."),
]
VerboseOption = Annotated[bool, typer.Option("--verbose", "-v", help="Show the logs of the solvers.")]


def run(
    config: ConfigArgument,
    out: OutOption = None,
    first: Annotated[
        Stage | None,
        typer.Option("--from", help="Run this stage and later ones again; earlier results must be up to date."),
    ] = None,
    last: Annotated[Stage | None, typer.Option("--to", help="Stop after this stage.")] = None,
    speed: SpeedOption = None,
    force: ForceOption = False,
    verbose: VerboseOption = False,
    no_why_not: NoWhyNotOption = False,
) -> None:
    """Run everything: regions, route, path, certificate, trajectory, figures and report.

    Only stages whose part of CONFIG, or whose earlier results, have changed
    are run; the others are kept. What a new result replaces moves to
    DIR/superseded, which may be deleted at any time; what is known of a
    failed stage is in DIR/failed.
    """
    _run(config, out, first, last, force, verbose, why_not=not no_why_not, speed=speed)


def route(
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
        typer.Option("--write-mps", metavar="FILE", help="Write the paper or compact program and do not solve it."),
    ] = None,
) -> None:
    """Stage one: find the regions, and the best route through them (a mixed-integer program).

    The route is proven optimal over all admitted moves between regions, or
    proven not to exist. Alternatives stray from each better route by
    route.alternative_distance grid steps, or change working modes otherwise.
    """
    changes = {} if formulation is None else {"formulation": formulation.value}
    if alternatives > 1 and write_mps is not None:
        raise UsageError("--write-mps goes with --alternatives 1: each alternative takes the better routes first")
    if alternatives > 1:
        from pipeline.cli.alternatives import plan_alternatives

        chosen = _with_changes(load(config), "route", changes)
        plan_alternatives(chosen, out or _RESULTS / chosen.name, alternatives, force, verbose, not no_why_not)
        return
    if write_mps is None:
        _run(config, out, None, Stage.ROUTE, force, verbose, changes, not no_why_not)
        return
    from pipeline.cli.program_file import write_program

    write_program(_with_changes(load(config), "route", changes), write_mps, messages_console())


def refine(
    config: ConfigArgument, out: OutOption = None, force: ForceOption = False, verbose: VerboseOption = False
) -> None:
    """Stage two: smooth the route into a path of splines in actuator space (a nonlinear program).

    Runs stage one before, unless its result in DIR is up to date.
    """
    _run(config, out, None, Stage.REFINE, force, verbose)


def certify(
    config: Annotated[
        Path | None, typer.Argument(metavar="CONFIG", help="The YAML file of machine, task and options.")
    ] = None,
    out: OutOption = None,
    force: ForceOption = False,
    verbose: VerboseOption = False,
    tolerance: Annotated[
        bool,
        typer.Option("--tolerance", help="Search the calibration errors the path is proven to bear, too."),
    ] = False,
    check: Annotated[
        Path | None,
        typer.Option("--check", metavar="FILE", help="Verify a certificate, or a run's, again, and search nothing."),
    ] = None,
) -> None:
    """Prove that the whole path is one motion free of singularities, and within its limits.

    Runs stages one and two before, unless their results in DIR are up to
    date. A certificate is verified again with --check by other code in other
    arithmetic; the run's config.yaml and path.npz have to be beside it.
    Tolerances once found are kept as long as the path is; with
    certify.what: tolerances in CONFIG every run searches them.
    """
    if check is not None:
        if config is not None or out is not None or force or tolerance:
            raise UsageError("--check FILE goes alone: the configuration is the one beside the certificate")
        from pipeline.cli.verification import verify_file

        verify_file(check, results_console())
        return
    if config is None:
        raise UsageError("certify needs a CONFIG, or --check FILE")
    _run(config, out, None, Stage.CERTIFY, force, verbose, tolerances=tolerance)


def retime(
    config: ConfigArgument,
    out: OutOption = None,
    speed: SpeedOption = None,
    force: ForceOption = False,
    verbose: VerboseOption = False,
) -> None:
    """Stage three: time the path within all limits, and write trajectory.csv and that of the way back.

    Runs stages one and two and the proof before, unless their results in
    DIR are up to date: other limits or another period cost seconds.
    """
    _run(config, out, None, Stage.RETIME, force, verbose, speed=speed)


def _run(
    path: Path,
    out: Path | None,
    first: Stage | None,
    last: Stage | None,
    force: bool,
    verbose: bool,
    route_changes: dict[str, str] | None = None,
    why_not: bool = True,
    tolerances: bool = False,
    speed: float | None = None,
) -> None:
    from pipeline.artifacts import sights
    from pipeline.cli.stage_table import stage_table
    from pipeline.run import run_pipeline
    from pipeline.run.reading import with_retime

    config = with_retime(_with_changes(load(path), "route", route_changes or {}), speed=speed)
    folder = out or _RESULTS / config.name
    with make_reporter(messages_console(), verbose) as reporter:
        report = run_pipeline(config, folder, first, last, force, reporter, verbose, why_not, tolerances)
    console = results_console()
    console.print(stage_table(report))
    stages = [outcome.stage for outcome in report.outcomes]
    found = sights(report.folder, stages)
    width = max(len(str(where)) for where, _ in found)
    for where, what in found:
        console.print(f"{where!s:<{width}}  {what}", soft_wrap=True)
    report.require_complete()
    console.print(f"Next: {_next_step(path, folder, out, stages[-1])}", soft_wrap=True)


def _with_changes(config: "Config", section: str, changes: dict[str, str]) -> "Config":
    """Apply options of the command line to a section."""
    if not changes:
        return config
    return config.model_copy(update={section: getattr(config, section).model_copy(update=changes)})


def load(path: Path) -> "Config":
    """Read a configuration, and make sure that the machine can be at its start and goal.

    Raises
    ------
    ConfigError
        When it cannot be used; names the file.
    """
    from pipeline.config.file import load_config
    from pipeline.machine.geometry import build_machine
    from pipeline.route.regions.endpoints import task_endpoints

    config = load_config(path)
    try:
        task_endpoints(config, build_machine(config.machine))
    except ConfigError as error:
        raise ConfigError(list(error.issues), str(path)) from None
    return config


def _next_step(path: Path, folder: Path, out: Path | None, last: Stage) -> str:
    """Recommend what to do after a run that ended with a stage."""
    from pipeline.artifacts.layout import REPORT

    config, results = shlex.quote(str(path)), shlex.quote(str(folder))
    where = f" --out {results}" if out else ""
    if last in (Stage.REGIONS, Stage.ROUTE):
        return f"gantry-tau refine {config}{where}"
    if last is Stage.FIGURES:
        return f"open {shlex.quote(str(folder / REPORT))} in a browser, then gantry-tau compare {results}"
    return f"gantry-tau compare {results}, and pictures with gantry-tau run {config}{where}"


COMMANDS: tuple[tuple[Callable[..., None], tuple[str, ...]], ...] = (
    (
        run,
        (
            "gantry-tau run configs/agder.yaml",
            "gantry-tau run configs/agder.yaml --out /tmp/try --to route    (regions and route only)",
            "gantry-tau run configs/agder.yaml --from retime    (path in time and figures, whatever has changed)",
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
    (
        certify,
        (
            "gantry-tau certify configs/agder.yaml",
            "gantry-tau certify configs/agder.yaml --tolerance    (a minute more)",
            "gantry-tau certify --check results/agder/certificate.json",
        ),
    ),
    (retime, ("gantry-tau retime configs/quick.yaml", "gantry-tau retime configs/quick.yaml --speed 0.3")),
)
"""Every command with its examples."""
