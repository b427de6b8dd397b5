"""The command that corrects the planned motion of a run for the machine as a calibration found it."""

import shlex
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from pipeline.cli.console import messages_console, results_console
from pipeline.cli.options import ForceOption, RunArgument, VerboseOption, naming, specs_of
from pipeline.cli.output import refuse_same, text_table
from pipeline.errors import NoSolutionError, UsageError
from pipeline.stage import Stage

if TYPE_CHECKING:
    from pipeline.config import Config
    from pipeline.correct import Motion, Verdict
    from pipeline.run import Results, RunOptions
    from pipeline.run.stage_specs import Specs

_HEADER = ("motion", "certified", "rms mm", "largest mm", "at s", "rms mrad", "largest mrad", "kappa", "duration s")
_TITLE = "how far the TCP of the calibrated machine is from where it was planned"
_Summary = dict[str, Any]


def correct(
    context: typer.Context,
    run: RunArgument,
    machine_file: Annotated[
        Path,
        typer.Option("--machine", metavar="FILE", help="The calibrated configuration; its section machine is used."),
    ],
    out: Annotated[
        Path | None,
        typer.Option("--out", metavar="DIR", help="Folder for the corrected motion. Default: RUN-corrected."),
    ] = None,
    again: Annotated[
        Path | None,
        typer.Option(
            "--plan-again",
            metavar="DIR",
            help="Also plan the task again for this machine, into that folder, and tell which is better.",
        ),
    ] = None,
    following: Annotated[
        bool,
        typer.Option("--following", help="Also search by how much drives may be off the corrected path (a minute)."),
    ] = False,
    force: ForceOption = False,
    verbose: VerboseOption = False,
    as_json: Annotated[bool, typer.Option("--json", help="Print JSON, in SI units.")] = False,
) -> None:
    """Correct the planned motion of a run for the machine as a calibration found it, and prove it for that machine.

    The actuators are corrected by splines dq(s), so that the poses are those
    that were planned, as near as this machine comes to them: where an arm
    changes its working mode it cannot be exactly there. Start and goal are met
    exactly. The result is a run folder with path, certificate and trajectory
    of this machine, in the units of its controller, for export and all other
    commands. All limits are checked, most of them proven, as for any path;
    the time law is found anew.

    --plan-again plans the same task for this machine, as run would, and
    compares both: planned again, a motion is exactly where it is planned, but
    may take another way.
    """
    from pipeline.config.choices import Proof
    from pipeline.correct import judge
    from pipeline.run import RunOptions, open_results

    out = run.parent / f"{run.name}-corrected" if out is None else out
    for other, name in ((run, "RUN"), (again, "--plan-again")):
        refuse_same(out, other, f"--out and {name}")
    refuse_same(again, run, "--plan-again and RUN")
    planned = open_results(run, Stage.REFINE)
    config = _for_machine(planned.config, machine_file)
    proof = Proof.FOLLOWING if following else None
    options = RunOptions(last=Stage.RETIME, force=force, verbose=verbose, proof=proof)
    with naming(machine_file):
        done, error = _attempt(lambda: _correct(planned, config, out, options))
        usual = specs_of(context)
        replanned, why = (None, None) if again is None else _attempt(lambda: _run(config, again, options, usual, {}))
    corrected = None if done is None else _motion(done)
    verdict = None
    if again is not None and (done is not None or replanned is not None):
        verdict = judge(corrected, None if replanned is None else _replanned(planned, replanned, again))
    if as_json:
        _print_json(done, replanned, verdict)
    else:
        _show(done, replanned, verdict)
    if error is not None:
        raise _advised(error, config, replanned is not None, why)
    if not as_json:
        _say_next(run, machine_file, out, None if again is not None else f"{run}-again")
    if why is not None:
        raise why


def _for_machine(config: "Config", file: Path) -> "Config":
    """Give the configuration of a run with the section `machine` of another file.

    Raises
    ------
    ConfigError
        When that file is no configuration, or does not go with the rest.
    UsageError
        When it is the same machine.
    """
    from pipeline.config.file import load_config, parse_config

    machine = load_config(file).machine
    if machine == config.machine:
        raise UsageError(
            f"{file} has the machine that was planned for: there is nothing to correct.\n"
            "  What to change: give the calibrated configuration (gantry-tau calibrate ... --output FILE)."
        )
    data = {**config.model_dump(mode="json"), "machine": machine.model_dump(mode="json")}
    return parse_config(data, source=str(file))


def _attempt(make: Callable[[], _Summary]) -> tuple[_Summary | None, NoSolutionError | None]:
    try:
        return make(), None
    except NoSolutionError as error:
        return None, error


def _correct(planned: "Results", config: "Config", out: Path, options: "RunOptions") -> _Summary:
    from pipeline.run.corrected.maker import Planned
    from pipeline.run.corrected.specs import corrected_specs

    given = Planned(planned.refinement, planned.config.machine)
    return _run(config, out, options, corrected_specs(given), {Stage.REFINE: lambda: given})


def _run(
    config: "Config", out: Path, options: "RunOptions", specs: "Specs", given: dict[Stage, Callable[[], Any]]
) -> _Summary:
    from pipeline.cli.reporter import make_reporter
    from pipeline.run import run_pipeline

    messages_console().print(f"{out}:", soft_wrap=True)
    with make_reporter(messages_console(), options.verbose) as reporter:
        report = run_pipeline(config, out, options, reporter, specs, given)
    report.require_complete()
    return report.summary


def _motion(summary: _Summary) -> "Motion":
    from pipeline.correct import measure_motion

    left_m = summary["path"]["correction"]["after"]["largest_m"]
    return measure_motion(summary, left_m, left_m)


def _replanned(planned: "Results", summary: _Summary, folder: Path) -> "Motion":
    """Measure a motion that was planned again: it is where it is planned, but may take another way."""
    import numpy as np

    from pipeline.correct import measure_motion
    from pipeline.correct.verdict import largest_distance
    from pipeline.run import open_results

    s = np.linspace(0.0, 1.0, planned.config.refine.check_points)
    path = open_results(folder, Stage.REFINE).refinement.path
    away_m = largest_distance(path.pose(s)[:, :3], planned.refinement.path.pose(s)[:, :3])
    return measure_motion(summary, 0.0, away_m)


def _show(done: _Summary | None, replanned: _Summary | None, verdict: "Verdict | None") -> None:
    console = results_console()
    if done is not None:
        facts = done["path"]["correction"]
        rows = [
            ("as planned", "-", *_error_cells(facts["before"]), "-", "-"),
            ("corrected", _certified(done), *_error_cells(facts["after"]), *_motion_cells(done)),
        ]
        if replanned is not None:
            rows.append(("planned again", _certified(replanned), *["-"] * 5, *_motion_cells(replanned)))
        console.print(text_table(_TITLE, _HEADER, rows, (0, 1)))
        for change in facts["mode_changes"]:
            way = "inside" if change["gap_m"] > 0.0 else "beyond"
            console.print(
                f"At s = {change['s']:.3f} arm {change['arm']} changes its working mode: there the planned poses are "
                f"{1e3 * abs(change['gap_m']):.3f} mm {way} its reach.",
                soft_wrap=True,
            )
        changes = ", ".join(f"{1e3 * value:.3f}" for value in facts["change_m"])
        console.print(f"Actuators are corrected by up to {changes} mm (c1, c2, c3, l2b, l3b).", soft_wrap=True)
        console.print(_proven(done), soft_wrap=True)
    if verdict is not None:
        console.print(f"Better here: {verdict.better}. {_sentence(verdict.reasons)}", soft_wrap=True)


def _sentence(reasons: tuple[str, ...]) -> str:
    text = "; ".join(reasons)
    return f"{text[:1].upper()}{text[1:]}."


def _error_cells(errors: dict[str, float]) -> tuple[str, ...]:
    return (
        *(f"{1e3 * errors[key]:.4f}" for key in ("rms_m", "largest_m")),
        f"{errors['largest_s']:.3f}",
        *(f"{1e3 * errors[key]:.4f}" for key in ("rms_rad", "largest_rad")),
    )


def _motion_cells(summary: _Summary) -> tuple[str, str]:
    return f"{summary['path']['kappa_max']:.2f}", f"{summary['trajectory']['duration_s']:.3f}"


def _certified(summary: _Summary) -> str:
    return "yes" if summary["certificate"].get("verdict") == "certified" else "no"


def _proven(summary: _Summary) -> str:
    """Say what is proven of the corrected motion, and of which machine."""
    if _certified(summary) == "no":
        return "Limits were checked at samples only: nothing is proven of the corrected path (certify.what: nothing)."
    return (
        "Proven for the calibrated machine: the corrected path is free of singularities, kappa up to "
        f"{summary['certificate']['kappa_bound']:.2f}, and within its limits; its time law, too. How far the real "
        "machine is from the calibrated one, calibrate says."
    )


def _say_next(run: Path, machine: Path, out: Path, again: str | None) -> None:
    console = results_console()
    console.print(f"{out}: the corrected run; trajectory.csv is in the units of its controller", soft_wrap=True)
    if again is None:
        console.print(f"Next: gantry-tau export {shlex.quote(str(out))}", soft_wrap=True)
        return
    words = ["gantry-tau", "correct", str(run), "--machine", str(machine), "--out", str(out), "--plan-again", again]
    console.print(f"Next: {shlex.join(words)}   (whether planning again is better)", soft_wrap=True)


def _print_json(done: _Summary | None, replanned: _Summary | None, verdict: "Verdict | None") -> None:
    from pipeline.artifacts import json_bytes

    def facts(summary: _Summary | None) -> _Summary | None:
        if summary is None:
            return None
        correction = summary["path"].get("correction")
        return {
            **({} if correction is None else {"correction": correction}),
            "verdict": summary["certificate"].get("verdict"),
            "kappa_bound": summary["certificate"].get("kappa_bound"),
            "kappa_max": summary["path"]["kappa_max"],
            "duration_s": summary["trajectory"]["duration_s"],
        }

    data = {"corrected": facts(done), "planned_again": facts(replanned)}
    judged = None if verdict is None else {"better": verdict.better, "reasons": list(verdict.reasons)}
    typer.echo(json_bytes({**data, "verdict": judged}), nl=False)


def _advised(
    error: NoSolutionError, config: "Config", planned_again: bool, why: NoSolutionError | None
) -> NoSolutionError:
    """Replace advice on planning, which is not what a correction can follow."""
    if planned_again:
        return error.with_advice("Take the motion that was planned again for this machine, which is there.")
    if why is not None:
        return error.with_advice(f"Planning again fails, too: {why.reason}. {why.advice}")
    return error.with_advice("Plan again for this machine: --plan-again DIR, or gantry-tau run with its configuration.")


COMMANDS: tuple[tuple[Callable[..., None], tuple[str, ...]], ...] = (
    (
        correct,
        (
            "gantry-tau correct results/agder --machine real.yaml",
            "gantry-tau correct results/agder --machine real.yaml --out results/real --plan-again results/again",
            "gantry-tau correct results/agder --machine real.yaml --json",
        ),
    ),
)
"""The command with its examples."""
