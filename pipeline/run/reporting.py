"""The report of a run folder: what is there is read, what failed or is missing is told of."""

from pathlib import Path
from typing import TYPE_CHECKING

from pipeline.artifacts import Record, State, open_run_folder, read_run_folder, write_whole
from pipeline.artifacts.layout import REPORT, failure_report
from pipeline.errors import PipelineError
from pipeline.machine.geometry import build_machine
from pipeline.run.reading import refuse_damage
from pipeline.run.stages import Results
from pipeline.stage import Stage

if TYPE_CHECKING:
    from pipeline.report import StageFacts


def write_report(folder: Path, output: Path | None = None) -> Path:
    """Write the report of a run, complete or not, into its folder or elsewhere; return where it is.

    In its folder, that of a run that failed is where all is that is known of failures.

    Raises
    ------
    UsageError
        When the folder holds no run, a run is at work in it, or what it holds was damaged.
    """
    config, _ = read_run_folder(folder)
    with open_run_folder(folder) as opened:
        for stage, record in opened.state.stages.items():
            # Pictures are no part of the report, which may be what was removed.
            if stage is not Stage.FIGURES:
                refuse_damage(folder, record)
        page = report_page(Results(config, build_machine(config.machine), folder), opened.state)
        target = folder / _name(opened.state) if output is None else output
        write_whole(target, page)
    return target


def _name(state: State) -> str:
    failed = [stage for stage, record in state.stages.items() if record.status == "failed"]
    return failure_report(failed[0]) if failed else REPORT


def report_page(results: Results, state: State) -> bytes:
    """Make the page of what there is of a run: results of the stages that the state says are done."""
    from pipeline.report import RunResults, build_report, render_page
    from pipeline.summary.sections import versions

    done = {stage for stage, record in state.stages.items() if record.status == "done"}
    proven = Stage.CERTIFY in done and results.config.certify.what != "nothing"
    run = RunResults(
        config=results.config,
        machine=results.machine,
        facts={stage: _facts(record) for stage, record in state.stages.items() if stage is not Stage.FIGURES},
        versions=versions(),
        refinement=results.refinement if Stage.REFINE in done else None,
        samples=results.samples if Stage.REFINE in done else None,
        bounds=results.certificate.bounds if proven else None,
        profile=results.profile if proven else None,
        trajectory=results.trajectory if Stage.RETIME in done else None,
    )
    return render_page(build_report(run)).encode()


def page_of_failure(results: Results, state: State) -> bytes | None:
    """Make the page of a run that failed; None where it cannot be made, which is no failure of its own."""
    if Stage.FIGURES in state.stages:
        return None
    try:
        return report_page(results, state)
    except PipelineError:
        return None


def _facts(record: Record) -> "StageFacts":
    from pipeline.report import StageFacts

    return StageFacts(record.status == "failed", record.summary, record.files)
