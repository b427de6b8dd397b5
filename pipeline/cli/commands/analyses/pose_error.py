"""The command that bounds how wrong the tool is for errors of drives and geometry."""

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from pipeline.cli.console import messages_console, results_console
from pipeline.cli.options import RunArgument
from pipeline.cli.output import check_output, check_picture, refuse_same, save_picture, text_table
from pipeline.cli.reporter import make_reporter
from pipeline.errors import UsageError
from pipeline.stage import Stage

if TYPE_CHECKING:
    from pipeline.inclusion.uncertainty import Uncertainty
    from pipeline.pose_error import PoseError
    from pipeline.run.results import Results

_MM = 1e-3
_MOST_MM = 100.0
_INTERVALS = 400
"""Intervals of s at which the largest amplification is looked for."""
_LENGTHS = typer.Option(
    "--lengths-mm", metavar="MM", min=0.0, max=_MOST_MM, help="How wrong the length of every link may be."
)
_COORDINATES = typer.Option(
    "--coordinates-mm",
    metavar="MM",
    min=0.0,
    max=_MOST_MM,
    help="How wrong every coordinate of every joint and rail may be.",
)


def pose_error(
    run: RunArgument,
    drives: Annotated[
        str | None,
        typer.Option(
            "--drives-mm",
            metavar="MM",
            help="How far every drive may be off the path, at any time; or five, of c1,c2,c3,l2b,l3b.",
        ),
    ] = None,
    lengths_mm: Annotated[float | None, _LENGTHS] = None,
    coordinates_mm: Annotated[float | None, _COORDINATES] = None,
    accuracy_mm: Annotated[
        float | None,
        typer.Option(
            "--accuracy-mm", metavar="MM", min=1e-4, max=_MOST_MM, help="Find which errors of drives this asks for."
        ),
    ] = None,
    output: Annotated[
        Path | None, typer.Option("--output", metavar="FILE", readable=False, help="Write the bound over s as CSV.")
    ] = None,
    picture: Annotated[
        Path | None,
        typer.Option("--picture", metavar="FILE", readable=False, help="Draw it with samples: .png, .pdf or .svg."),
    ] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print JSON, unrounded, in metres and radians.")] = False,
) -> None:
    """Prove how far the tool may be off, all along the path of a run, for errors of drives and geometry.

    Without --drives-mm, --lengths-mm and --coordinates-mm the errors are
    those of certify.pose_error in the run's configuration, with which a run
    writes pose_error.csv itself. Errors of drives may vary with time; only
    what is off the path counts, not that all drives are late together.

    With --accuracy-mm, find how far drives may be off for a tool that
    accurate, beside errors of the geometry: all drives alike, drives with
    equal shares of the tool's error, and each drive alone.
    """
    check_output(output, run)
    check_picture(picture, run)
    refuse_same(output, picture, "--output and --picture")
    from pipeline.run.reading import open_results

    results = open_results(run, Stage.REFINE)
    uncertainty = _errors(results, _drives_m(drives), lengths_mm, coordinates_mm)
    if accuracy_mm is not None:
        if drives is not None or output is not None or picture is not None:
            raise UsageError(
                "--accuracy-mm finds the errors of drives: it excludes --drives-mm, --output and --picture"
            )
        _show_tolerances(results, uncertainty, _MM * accuracy_mm, as_json)
        return
    if not uncertainty.any:
        asked = (drives, lengths_mm, coordinates_mm) != (None, None, None)
        why = "all errors given are 0" if asked else f"certify.pose_error is null in {run}"
        raise UsageError(
            f"{why}: nothing is off, and there is nothing to bound.\n"
            "  What to change: give a --drives-mm, --lengths-mm or --coordinates-mm above 0"
            f"{', or none for the errors in certify.pose_error' if asked and _configured(results) else ''}."
        )
    found = _bound(results, uncertainty)
    _show(found, str(run), as_json)
    if output is not None:
        _write(found, output)
    if picture is not None:
        _draw(results, found, picture)


def _configured(results: "Results") -> bool:
    return results.config.certify.pose_error is not None


def _drives_m(text: str | None) -> tuple[float, ...] | None:
    """Read one error of all drives in millimetres, or five.

    Raises
    ------
    UsageError
        When that is not what it is.
    """
    if text is None:
        return None
    try:
        errors = tuple(_MM * float(part) for part in text.split(","))
    except ValueError:
        errors = ()
    if len(errors) not in (1, 5) or not all(0.0 <= error <= _MM * _MOST_MM for error in errors):
        raise UsageError(
            f"--drives-mm {text}: expected one error from 0 to {_MOST_MM:g} mm, or five, separated by commas: 0.1"
        )
    return errors * 5 if len(errors) == 1 else errors


def _errors(
    results: "Results", drives_m: tuple[float, ...] | None, lengths_mm: float | None, coordinates_mm: float | None
) -> "Uncertainty":
    """Give the errors asked for; if none are, those of the configuration."""
    from pipeline.artifacts.results.pose_error import uncertainty_of
    from pipeline.inclusion.uncertainty import CERTAIN, Uncertainty

    if drives_m is None and lengths_mm is None and coordinates_mm is None:
        configured = results.config.certify.pose_error
        return CERTAIN if configured is None else uncertainty_of(configured)
    return Uncertainty(_MM * (lengths_mm or 0.0), _MM * (coordinates_mm or 0.0), drives_m or (0.0,) * 5)


def _bound(results: "Results", uncertainty: "Uncertainty") -> "PoseError":
    from pipeline.pose_error import bound_pose_error
    from pipeline.progress import Monitor

    with make_reporter(messages_console(), verbose=False) as reporter:
        monitor = Monitor(reporter.begin("pose error"))
        return bound_pose_error(results.refinement.path, uncertainty, results.config.certify.precision_bits, monitor)


def _show(found: "PoseError", title: str, as_json: bool) -> None:
    from dataclasses import asdict

    from pipeline.artifacts import json_bytes
    from pipeline.machine.geometry import ACTUATORS
    from pipeline.summary.pose_error import pose_error_part

    part = pose_error_part(found)
    if as_json:
        typer.echo(json_bytes({"errors": asdict(found.uncertainty), **part, "boxes": len(found.position_m)}), nl=False)
        return
    rows = [
        (name, f"{1e3 * error:g}", f"{gain:.2f}", f"{s:.3f}", f"{turn:.2f}")
        for name, error, gain, s, turn in zip(
            ACTUATORS,
            found.uncertainty.actuator_m,
            part["amplification_max"],
            part["amplification_max_s"],
            part["rotation_max_radpm"],
            strict=True,
        )
    ]
    geometry = (("every length", found.uncertainty.length_m), ("every coordinate", found.uncertainty.coordinate_m))
    rows += [(name, f"{1e3 * error:g}", "-", "-", "-") for name, error in geometry]
    header = ("off", "by mm", "tool mm per mm", "at s", "mrad per mm")
    console = results_console()
    console.print(text_table(f"{title}: what is off, and what the tool does with each drive", header, rows))
    console.print(
        f"proven by {len(found.position_m)} boxes: the tool is off by at most "
        f"{1e3 * part['pose_error_bound_m']:.4g} mm (near s = {part['pose_error_bound_s']:.3f}) and turned by "
        f"{1e3 * part['pose_error_rotation_rad']:.4g} mrad (near s = {part['pose_error_rotation_s']:.3f})",
        soft_wrap=True,
    )


def _show_tolerances(results: "Results", geometry: "Uncertainty", accuracy_m: float, as_json: bool) -> None:
    import numpy as np

    from pipeline.artifacts import json_bytes
    from pipeline.machine.geometry import ACTUATORS
    from pipeline.pose_error import amplify_drives, bound_pose_error, find_drive_tolerances
    from pipeline.progress import Monitor

    path, bits = results.refinement.path, results.config.certify.precision_bits
    gains = amplify_drives(path, np.linspace(0.0, 1.0, _INTERVALS + 1)).position.max(axis=0)

    def bound(uncertainty: "Uncertainty") -> float:
        return float(bound_pose_error(path, uncertainty, bits).position_m.max())

    with make_reporter(messages_console(), verbose=False) as reporter:
        monitor = Monitor(reporter.begin("pose error"))
        found = find_drive_tolerances(bound, gains, geometry, accuracy_m, monitor)
    if as_json:
        data = {
            name.replace(" ", "_"): {"drives_m": one.errors_m, "bound_m": one.bound_m} for name, one in found.items()
        }
        typer.echo(json_bytes({"accuracy_m": accuracy_m, "tolerances": data}), nl=False)
        return
    rows = [
        (f"{name} alone" if name in ACTUATORS else name, *(f"{1e3 * error:.4g}" for error in one.errors_m.tolist()))
        + (f"{1e3 * one.bound_m:.4g}",)
        for name, one in found.items()
    ]
    title = f"{results.folder}: how far drives may be off, in mm, for a tool within {1e3 * accuracy_m:g} mm"
    results_console().print(text_table(title, ("drives", *ACTUATORS, "proven mm"), rows))


def _write(found: "PoseError", output: Path) -> None:
    from pipeline.artifacts.layout import POSE_ERROR_CSV
    from pipeline.artifacts.output import write_output
    from pipeline.artifacts.results.pose_error import pose_error_files

    write_output(output, pose_error_files(found)[POSE_ERROR_CSV])
    messages_console().print(f"{output}: the bound over {len(found.position_m)} intervals of s", soft_wrap=True)


def _draw(results: "Results", found: "PoseError", picture: Path) -> None:
    from pipeline.figures.proven.pose_error import pose_error_figure
    from pipeline.pose_error import sample_pose_error

    sampled = sample_pose_error(results.refinement.path, found.uncertainty, found.middles)
    save_picture(pose_error_figure(found, sampled), picture)
    messages_console().print(f"{picture}: the bound with samples, and the amplification of each drive", soft_wrap=True)


COMMANDS: tuple[tuple[Callable[..., None], tuple[str, ...]], ...] = (
    (
        pose_error,
        (
            "gantry-tau pose-error results/agder --drives-mm 0.1",
            "gantry-tau pose-error results/agder --drives-mm 0.1,0.1,0.1,0.05,0.05 --picture error.png",
            "gantry-tau pose-error results/agder --accuracy-mm 0.1    (a quarter of a minute)",
        ),
    ),
)
"""The command with its examples."""
