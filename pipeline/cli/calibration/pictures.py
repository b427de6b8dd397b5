"""Pictures of a calibration: a file per figure, beside the name that was given."""

from pathlib import Path
from typing import TYPE_CHECKING

from pipeline.cli.console import messages_console
from pipeline.cli.output import check_picture, refuse_same, save_picture
from pipeline.cli.reporter import make_reporter
from pipeline.errors import NoSolutionError, UsageError

if TYPE_CHECKING:
    from pipeline.calibrate import Calibration, Verdict

NAMES = ("residuals", "parameters", "singular_values", "workspace", "poses")
"""The figures, as `CALIBRATION_FIGURES` has them: known without loading what draws."""


def picture_files(picture: Path) -> dict[str, Path]:
    """Name the file of every figure: cell.png gives cell-residuals.png and so on."""
    return {name: picture.with_name(f"{picture.stem}-{name}{picture.suffix}") for name in NAMES}


def check_pictures(picture: Path | None, others: list[Path]) -> None:
    """Check where pictures go, before anything is computed.

    Raises
    ------
    UsageError
        When the ending is not one of a picture, or a file must not be written, see `check_picture`.
    OSError
        When a file may not be written.
    """
    if picture is None:
        return
    check_picture(picture)
    for file in picture_files(picture).values():
        check_picture(file)
        for other in others:
            refuse_same(file, other, "a picture and another file")


def require_no_pictures(picture: Path | None) -> None:
    """Refuse pictures where nothing was measured yet.

    Raises
    ------
    UsageError
        When they are asked for.
    """
    if picture is not None:
        raise UsageError("--picture draws what was measured: give a FILE, or leave it out")


def draw_pictures(calibration: "Calibration", verdict: "Verdict", picture: Path | None) -> None:
    """Draw and write all figures, where they are asked for; one for which the machine has no poses is left out."""
    if picture is None:
        return
    from pipeline.figures.calibration import calibration_figure

    files, left_out = picture_files(picture), {}
    with make_reporter(messages_console(), verbose=False) as reporter:
        progress = reporter.begin("figures")
        for number, (name, file) in enumerate(files.items()):
            progress(f"figure of {name.replace('_', ' ')}", number / len(files))
            try:
                save_picture(calibration_figure(name, calibration, verdict), file)
            except NoSolutionError as error:
                left_out[file] = error.reason
    for file, reason in left_out.items():
        messages_console().print(f"{file} is left out: {reason}", soft_wrap=True)
    written = picture.with_name(f"{picture.stem}-*{picture.suffix}")
    messages_console().print(f"{written}: {len(files) - len(left_out)} figures", soft_wrap=True)
