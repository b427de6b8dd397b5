"""The command that runs a study: many runs of a configuration that varies."""

from collections import Counter
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from pipeline.cli.console import messages_console, results_console
from pipeline.cli.output import text_table
from pipeline.cli.reporter import make_reporter
from pipeline.errors import UsageError

if TYPE_CHECKING:
    from pipeline.study.study import Outcome

_REPORT = "report"
"""The word in the place of the study's file that asks for nothing but the report."""


def study(
    study: Annotated[
        Path, typer.Argument(metavar="STUDY", help="The YAML file of the study; or the word report, before a DIR.")
    ],
    folder: Annotated[
        Path | None, typer.Argument(metavar="DIR", help="After the word report: the folder of a study.")
    ] = None,
    scheduler: Annotated[
        str | None,
        typer.Option(
            "--scheduler",
            metavar="ADDRESS",
            help="Use the workers of this Dask scheduler, such as tcp://10.0.0.1:8786.",
        ),
    ] = None,
    workers: Annotated[
        int | None,
        typer.Option(
            "--workers", metavar="N", min=1, max=1_024, help="Workers on this machine. Default: as many as fit."
        ),
    ] = None,
    out: Annotated[
        Path | None,
        typer.Option("--out", metavar="DIR", help="Folder for the study. Default: results/<name of the study>."),
    ] = None,
    retry: Annotated[
        bool,
        typer.Option("--retry", help="Also run again what ended at its time limit, killed its worker, or by an error."),
    ] = False,
) -> None:
    """Run a configuration many times, with keys that vary, on all processors or on a cluster.

    Every run has a folder like that of `run`, and a row in study.csv and
    study.parquet: parameters, how it ended, figures. What is done stays
    done: after Ctrl-C, or whatever ended it, the same command goes on from
    there. `gantry-tau study report DIR` writes table and report again, also
    of a study that is not finished.
    """
    if str(study) == _REPORT and folder is not None:
        given = {"--scheduler": scheduler, "--workers": workers, "--out": out, "--retry": retry or None}
        if unused := [option for option, value in given.items() if value is not None]:
            raise UsageError(
                f"{' and '.join(unused)} cannot go with study report, which runs nothing, and writes into {folder}"
            )
        from pipeline.study.study import report_study

        _show(report_study(folder))
        return
    if folder is not None:
        raise UsageError(f"{folder}: only the word report is followed by a folder; --out says where a study goes")
    if scheduler is not None and workers is not None:
        raise UsageError("--workers is for this machine: a scheduler has workers of its own")
    from pipeline.config.file import results_folder
    from pipeline.progress import Monitor, Progress
    from pipeline.study.config import load_study
    from pipeline.study.study import Workers, run_study

    target = out or results_folder(load_study(study).name)
    with make_reporter(messages_console(), verbose=False) as reporter:
        began: list[Progress] = []

        def progress(message: str, fraction: float | None = None) -> None:
            # Only once the study is known to be valid.
            began[:] = began or [reporter.begin("study")]
            began[0](message, fraction)

        outcome = run_study(study, target, Workers(scheduler, workers), retry, Monitor(progress))
    _show(outcome)


def _show(outcome: "Outcome") -> None:
    from pipeline.study.study import FILES

    status, reasons = outcome.table.columns["status"], outcome.table.columns["reason"]
    counts = Counter((ending, reason or "") for ending, reason in zip(status, reasons, strict=True))
    rows = [(ending, reason, f"{count:,}") for (ending, reason), count in counts.most_common()]
    title = f"{outcome.folder}: {len(outcome.table):,} of {outcome.total:,} runs"
    results_console().print(text_table(title, ("status", "reason", "runs"), rows, (0, 1)))
    for note in outcome.notes:
        messages_console().print(f"note: {note}", soft_wrap=True)
    for name in FILES:
        results_console().print(str(outcome.folder / name), soft_wrap=True)


COMMANDS: tuple[tuple[Callable[..., None], tuple[str, ...]], ...] = (
    (
        study,
        (
            "gantry-tau study configs/studies/four_dof.yaml",
            "gantry-tau study configs/studies/four_dof.yaml --workers 2 --out /tmp/four_dof",
            "gantry-tau study configs/studies/four_dof.yaml --scheduler tcp://10.0.0.1:8786",
            "gantry-tau study report results/four_dof",
            "and a study of your own, beside my-cell.yaml, of four runs:",
            "base: my-cell.yaml",
            "to: retime",
            "parameters:",
            "  - {key: task.tilt_max_deg, values: [15, 20, 25, 30]}",
            "figures: [path.kappa_max, trajectory.duration_s]",
        ),
    ),
)
"""The command with its examples."""
