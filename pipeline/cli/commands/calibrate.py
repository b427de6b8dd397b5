"""The command that corrects the configuration of a machine by what a tracker saw of it."""

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from pipeline.cli.calibration.next_poses import begin, check_next, propose
from pipeline.cli.calibration.pictures import check_pictures, draw_pictures, require_no_pictures
from pipeline.cli.console import messages_console, results_console
from pipeline.cli.motions.calibration_setting import fitted_kinds, prior_deviations
from pipeline.cli.motions.driven import DrivenBack, DrivenPeriod, DrivenSpeed, driven_motion
from pipeline.cli.motions.reflector_options import (
    FirstReflector,
    SecondReflector,
    ThirdReflector,
    reflector_places,
)
from pipeline.cli.options import ConfigArgument
from pipeline.cli.output import check_facts, print_json, refuse_same, text_table
from pipeline.errors import NoSolutionError, UsageError

if TYPE_CHECKING:
    from rich.console import Console

    from pipeline.calibrate import Calibration, Verdict
    from pipeline.config import Config


def calibrate(
    config_file: ConfigArgument,
    files: Annotated[
        list[Path] | None, typer.Argument(metavar="FILE", help="CSV files with measured poses or motions.")
    ] = None,
    first: FirstReflector = None,
    second: SecondReflector = None,
    third: ThirdReflector = None,
    output: Annotated[
        Path | None,
        typer.Option(
            "--output", metavar="FILE", readable=False, help="Where to write the calibrated configuration to."
        ),
    ] = None,
    noise_m: Annotated[
        float,
        typer.Option(
            "--noise", metavar="M", min=1e-9, max=0.1, help="Standard deviation of each coordinate in metres."
        ),
    ] = 5e-5,
    prior: Annotated[
        list[str] | None,
        typer.Option(
            "--prior",
            metavar="[KIND=]STD",
            help="Standard deviation of what is known beforehand: of lengths in metres, or of one kind of parameter.",
        ),
    ] = None,
    reflector_std_m: Annotated[
        float | None,
        typer.Option("--reflector-std", metavar="M", min=1e-9, max=0.1, help="The same for the places of reflectors."),
    ] = None,
    fit: Annotated[
        str | None,
        typer.Option(
            "--fit", metavar="KINDS", help="What may change, separated by commas. Default: all but directions."
        ),
    ] = None,
    robust: Annotated[bool, typer.Option("--robust", help="Find points that are wrong, and leave them out.")] = False,
    hold_out: Annotated[
        float,
        typer.Option(
            "--hold-out", metavar="PART", min=0.0, max=0.9, help="Part of the poses that only checks the result."
        ),
    ] = 0.0,
    following: Annotated[
        int, typer.Option("--next", metavar="N", min=0, max=200, help="Number of poses to propose for measuring next.")
    ] = 0,
    next_file: Annotated[
        Path | None,
        typer.Option("--next-output", metavar="FILE", readable=False, help="Where to write these poses to, as CSV."),
    ] = None,
    picture: Annotated[
        Path | None,
        typer.Option(
            "--picture",
            metavar="FILE",
            readable=False,
            help="Draw five figures beside that name, FILE-residuals and so on: .png, .pdf or .svg.",
        ),
    ] = None,
    run: Annotated[
        Path | None,
        typer.Option("--run", metavar="RUN", help="The run that was driven in files of motions, with times t_s."),
    ] = None,
    speed: DrivenSpeed = None,
    period_s: DrivenPeriod = None,
    back: DrivenBack = False,
    as_json: Annotated[bool, typer.Option("--json", help="Print JSON with everything, covariance included.")] = False,
) -> None:
    """Correct the configuration of a machine by what a tracker saw of it, and say how sure that is.

    Files have a row per pose at which the machine stood still: what its
    encoders showed (q1_m to q5_m), and where reflectors on the platform were
    seen (x1_m, y1_m, z1_m; x2_m ...), empty where one was not, in whatever
    frame the tracker has. Kinds of parameters are platform, offsets, rails,
    lengths, zeros, scales, directions, reflectors, clocks.

    Files with times t_s instead of encoders are of the motion of --run, as
    it was driven (--speed, --period, --back); by how much the clock of the
    tracker is late is fitted for each, up to 2 s. What drives are off their
    commands is not known there: static poses are better.

    --output gets the configuration with all else, comments included, as it
    is, and beside it a file .json with everything. Exits with 1, and writes
    nothing, if the poses do not determine the machine or no machine explains
    them; the reason says what does. Directions of rails are fitted if --fit
    says so, and written as slopes.

    --picture cal.png draws residuals, changes of parameters, singular values,
    errors over the workspace and by the number of poses: cal-residuals.png,
    cal-parameters.png, cal-singular_values.png, cal-workspace.png and
    cal-poses.png.

    --next 20 proposes poses that would add most to what is known; without a
    FILE a dozen moderate ones to begin with. --next-output has them as a
    table to be filled in: drive there, write down what the encoders show and
    where reflectors are seen.
    """
    reflectors_m = reflector_places(first, second, third)
    from pipeline.calibrate import Setting

    priors = prior_deviations(prior, reflector_std_m)
    setting = Setting(noise_m, fitted_kinds(fit), priors, robust, hold_out)
    beside = _check_files(output, [config_file, *(files or [])])
    check_next(next_file, following, [config_file, *(files or []), *([] if output is None else [output])])
    check_pictures(picture, [config_file, *(files or []), *(one for one in (output, next_file) if one is not None)])
    config, text = _load(config_file)
    if not files:
        require_no_pictures(picture)
        begin(config, reflectors_m, setting, (output, following, next_file), as_json)
        return
    from pipeline.calibrate import calibrate as identify
    from pipeline.calibrate import calibrated_yaml, judge, next_poses, read_poses
    from pipeline.calibrate.report import calibration_data, next_data

    poses, read = read_poses(files, len(reflectors_m), driven_motion(run, speed, period_s, back))
    if run is not None and not poses.motions:
        raise UsageError("--run goes with files of motions, with times t_s: none is given")
    for one in read:
        messages_console().print(one.account.message(), soft_wrap=True)
    calibration = identify(config, reflectors_m, poses, setting)
    verdict = judge(calibration)
    data = calibration_data(calibration, verdict, read)
    proposed = next_poses(calibration, following) if following else None
    # A pipe that the configuration goes into may be stdout: there it is alone.
    console = messages_console() if output is not None and beside is None else results_console()
    if as_json:
        print_json(data if proposed is None else {**data, "next": next_data(proposed)})
    else:
        _show(calibration, verdict, console)
    if proposed is not None:
        propose(proposed, len(reflectors_m), next_file, None if as_json else console)
    draw_pictures(calibration, verdict, picture)
    if not verdict.accepted:
        reason, advice = "\n  ".join(verdict.reasons).rsplit("\n  What to change: ", 1)
        raise NoSolutionError("calibrate", reason, advice)
    if output is not None:
        heading = f"Calibrated by gantry-tau from {', '.join(sorted({file.name for file in files}))}."
        new = calibrated_yaml(text, config, calibration.identification.model, heading)
        _write(new, output, beside, data)


def _check_files(output: Path | None, read: list[Path]) -> Path | None:
    """Check where results go, before anything is computed; give the name of the file beside the configuration."""
    if output is None:
        return None
    beside = check_facts(output, lambda facts: "covariance" in facts and "parameters" in facts)
    for other in read:
        refuse_same(output, other, "--output and a file that is read")
        refuse_same(beside, other, "the file beside --output and a file that is read")
    return beside


def _load(config_file: Path) -> "tuple[Config, str]":
    """Read a configuration, and its text: once, as it may be a pipe."""
    from pipeline.config.file import load_config
    from pipeline.regular_file import read_named_file

    content = b""

    def read(path: Path, most: int) -> bytes:
        nonlocal content
        content = read_named_file(path, most)
        return content

    return load_config(config_file, read), content.decode().removeprefix("\ufeff")


def _show(calibration: "Calibration", verdict: "Verdict", console: "Console") -> None:
    from pipeline.calibrate.report import ERROR_HEADER, error_cells, motion_words, parameter_tables

    for table in parameter_tables(calibration):
        console.print(text_table(table.title, table.header, table.rows, (0, 5)))
    console.print(text_table("distances of points, root mean square", ERROR_HEADER, error_cells(calibration)))
    console.print(
        f"chi-square {verdict.chi2:,.1f}, expected {verdict.freedom:,}; {verdict.directions} parameters, of whose "
        f"directions {verdict.gauges} change nothing that is seen, and {verdict.from_data} are from the data",
        soft_wrap=True,
    )
    for said in motion_words(calibration):
        console.print(said, soft_wrap=True)


def _write(text: str, output: Path, beside: Path | None, data: dict[str, Any]) -> None:
    """Write the configuration, and beside it, if there is such a file, everything about it."""
    from pipeline.artifacts import json_bytes, write_whole
    from pipeline.artifacts.output import write_output

    said = f"{output}: the calibrated machine"
    if beside is not None:
        write_whole(beside, json_bytes(data))
        said += f"; {beside}: everything about it"
    write_output(output, text.encode())
    messages_console().print(said, soft_wrap=True)


COMMANDS: tuple[tuple[Callable[..., None], tuple[str, ...]], ...] = (
    (
        calibrate,
        (
            "gantry-tau calibrate cell.yaml poses.csv --reflector-1 0 .1 .05 --reflector-2 0 .4 .05 --output real.yaml",
            "gantry-tau calibrate cell.yaml day1.csv day2.csv --reflector-1 0 .1 .05 --robust --picture cal.png",
            "gantry-tau calibrate cell.yaml poses.csv --reflector-1 0 .1 .05 --prior 0.0005 --prior scales=0.0002",
            "gantry-tau calibrate cell.yaml poses.csv motion.csv --run results/cell --reflector-1 0 .1 .05",
            "gantry-tau calibrate cell.yaml --reflector-1 0 .1 .05 --next 12 --next-output first.csv",
            "gantry-tau calibrate cell.yaml first.csv --reflector-1 0 .1 .05 --next 28 --next-output then.csv",
        ),
    ),
)
"""The command with its examples."""
