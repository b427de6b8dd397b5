"""A study from its file to its table and report: what the command does."""

import contextlib
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import yaml

from pipeline.artifacts import write_whole
from pipeline.artifacts.layout import LOCK, SUMMARY, failure_report
from pipeline.artifacts.layout import REPORT as RUN_REPORT
from pipeline.artifacts.lock import locked_study
from pipeline.errors import UsageError
from pipeline.progress import QUIET, Monitor
from pipeline.stage import STAGES
from pipeline.study.cases import SECTIONS, Cases, build_cases
from pipeline.study.config import Kind, StudyConfig, load_study
from pipeline.study.engine import Engine, Setting
from pipeline.study.extra import library
from pipeline.study.optimise.trials import ended_cases, source_of
from pipeline.study.pool import Pool, local_pool, remote_pool
from pipeline.study.program import program_version
from pipeline.study.report import REPORT, render_study
from pipeline.study.store import STORE, Store
from pipeline.study.table import CSV, PARQUET, Table, build_table, unknown_figures, write_table

STUDY, BASE = "study.yaml", "base.yaml"
FILES = (CSV, PARQUET, REPORT)
"""What a study is read by."""


@dataclass(frozen=True)
class Workers:
    """Where the runs of a study go.

    Attributes
    ----------
    scheduler : str or None
        The address of a scheduler of Dask's; None: workers are started on this machine.
    count : int or None
        How many workers are started here; None: as many as processors and memory allow.
    """

    scheduler: str | None = None
    count: int | None = None


@dataclass(frozen=True)
class Outcome:
    """What there is of a study.

    Attributes
    ----------
    folder : Path
        Where it is.
    table : Table
        The runs that have ended.
    total : int
        How many runs it has, ended or not.
    notes : tuple of str
        Figures that were asked for and that no run has.
    """

    folder: Path
    table: Table
    total: int
    notes: tuple[str, ...]


def run_study(file: Path, folder: Path, workers: Workers, retry: bool = False, monitor: Monitor = QUIET) -> Outcome:
    """Run what is not done of a study, and write its table and report, also when it is interrupted.

    Raises
    ------
    ConfigError
        When the study or its configuration is not valid; nothing was run.
    UsageError
        When the folder is not that of a study, another client leads it, the scheduler does not answer, a worker is of
        another program, or a library is missing.
    PipelineError
        When the scheduler is lost.
    """
    study = load_study(file)
    for name in ("distributed", "pyarrow.parquet", *(("optuna",) if study.design.kind is Kind.OPTIMISE else ())):
        library(name)
    program = program_version()
    cases = build_cases(study, file, program)
    _require_study_folder(folder)
    folder.mkdir(parents=True, exist_ok=True)
    with locked_study(folder), Store(folder) as store:
        _keep_study(folder, cases)
        store.set_program(program)
        setting = Setting(folder.resolve(), study.to, program, study.run, retry)
        try:
            with contextlib.ExitStack() as stack:
                engine = Engine(setting, _opened(stack, workers, cases), store, len(cases), monitor)
                engine.lead(source_of(cases))
        finally:
            outcome = _write(folder, cases, store)
    return outcome


def report_study(folder: Path) -> Outcome:
    """Write table and report of a study again, from what is done of it.

    Raises
    ------
    UsageError
        When the folder is not that of a study, or a client is leading it.
    """
    if not (folder / STORE).exists():
        raise UsageError(f"{folder} is not the folder of a study: it has no {STORE}")
    with locked_study(folder), Store(folder) as store:
        study = load_study(folder / STUDY)
        program = store.program() or program_version()
        cases = build_cases(study, folder / STUDY, program)
        if next(store.rows(), None) is not None and next(ended_cases(cases, store), None) is None:
            raise UsageError(
                f"{folder} has results of {program} alone, and this program has other keys: nothing was changed.\n"
                f"  What to change: read its table as it is, or run it again, with gantry-tau study {folder / STUDY} "
                f"--out {folder}."
            )
        return _write(folder, cases, store)


def _opened(stack: contextlib.ExitStack, workers: Workers, cases: Cases) -> Callable[[], Pool]:
    """Give the function that opens the pool, once it is needed: a study that is done needs none."""

    def pool() -> Pool:
        if workers.scheduler is not None:
            return stack.enter_context(remote_pool(workers.scheduler, cases.program))
        memory_gb = float(cases.base["route"]["memory_gb"]) + 0.2
        return stack.enter_context(local_pool(workers.count, cases.study.run.threads, memory_gb))

    return pool


def _require_study_folder(folder: Path) -> None:
    if folder.exists() and not folder.is_dir():
        raise UsageError(f"{folder} is not a folder: give another one with --out")
    if not folder.is_dir() or (folder / STORE).exists() or all((folder / name).exists() for name in (STUDY, BASE)):
        return
    # A client that is killed as it begins leaves its lock alone.
    if any(entry.name != LOCK for entry in folder.iterdir()):
        raise UsageError(
            f"{folder} is not empty, and not the folder of a study (it has neither {STORE} nor {STUDY} and {BASE}): "
            "nothing was changed.\n"
            "  What to change: give another folder with --out, or move away what is there."
        )


def _keep_study(folder: Path, cases: Cases) -> None:
    """Write the study and the configuration it varies into its folder, which then needs no other file."""
    base = {key: value for key, value in cases.base.items() if key not in SECTIONS}
    study: StudyConfig = cases.study.model_copy(update={"base": BASE})
    for name, data in ((BASE, base), (STUDY, study.model_dump(mode="json", exclude_defaults=True))):
        text = yaml.safe_dump(data, sort_keys=False, default_flow_style=None, width=110, allow_unicode=True)
        write_whole(folder / name, text.encode())


def _write(folder: Path, cases: Cases, store: Store) -> Outcome:
    table = build_table(cases, store)
    write_table(folder, table)
    write_whole(folder / REPORT, render_study(cases.study, table, len(cases), lambda run: _page_of(folder, run)))
    return Outcome(folder, table, len(cases), tuple(unknown_figures(cases.study, table, store)))


def _page_of(folder: Path, run: str) -> str:
    """Name what tells most of a run: its report, that of its failure, its figures, its folder."""
    names = (RUN_REPORT, *(failure_report(stage) for stage in STAGES), SUMMARY)
    return next((f"{run}/{name}" for name in names if (folder / run / name).exists()), f"{run}/")
