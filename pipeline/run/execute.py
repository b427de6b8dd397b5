"""Running stages: which ones are up to date, which ones run, and what happens to old results."""

import time
from collections.abc import Callable, Mapping
from hashlib import sha256
from pathlib import Path
from typing import Any, Literal

from pipeline.artifacts import Record, RunFolder, State, existing_files, jsonable, open_run_folder, read_state
from pipeline.artifacts.layout import failure_names, failure_picture, failure_report, own_files
from pipeline.config import Config
from pipeline.config.file import config_sha256, dump_config
from pipeline.errors import ConfigError, NoSolutionError, PipelineError, UsageError
from pipeline.machine.geometry import build_machine
from pipeline.progress import Monitor
from pipeline.route.regions.counting import require_possible_task
from pipeline.route.regions.size import require_grid_fits
from pipeline.run.beside.process import SecondProcess
from pipeline.run.diagnosis import Diagnosis
from pipeline.run.failure import failure_product, is_proven_infeasible
from pipeline.run.options import RunOptions
from pipeline.run.product import Product
from pipeline.run.reporter import Quiet, Reporter
from pipeline.run.results import Results
from pipeline.run.run_report import Outcome, RunReport
from pipeline.run.stage_specs import SPECS, Specs, report_of, spec_of, stages_up_to
from pipeline.run.up_to_date.check import expected_fingerprint, matching_records, why_outdated
from pipeline.stage import Stage
from pipeline.summary.path import CORRECTION
from pipeline.summary.section import failed_part
from pipeline.summary.whole import summarise

_DEFAULT = RunOptions()


def run_pipeline(
    config: Config,
    out: Path | str,
    options: RunOptions = _DEFAULT,
    reporter: Reporter | None = None,
    specs: Specs = SPECS,
    given: Mapping[Stage, Callable[[], Any]] | None = None,
) -> RunReport:
    """Run the stages whose inputs have changed, and write their results to the folder `out`.

    A part of a result may have failed, see `RunReport.require_complete`.

    Parameters
    ----------
    options : RunOptions
        Which stages run, and how.
    reporter : Reporter, optional
        Is notified when stages begin and end.
    specs : tuple of StageSpec
        The stages.
    given : mapping, optional
        Functions that give regions and route, where they are known for this configuration.

    Raises
    ------
    ConfigError
        When the machine cannot be at the start or goal, the task is impossible by counting, or the grid takes up more
        memory than allowed; nothing was changed.
    UsageError
        When the stages asked for are not a range, results they need are missing or outdated, or the folder is not one
        that a run may write to.
    NoSolutionError
        When a stage has no solution, and the run folder keeps the reason; or when the route is not proven optimal,
        and `options.unproven` is not set: it is kept like any result, but no later stage runs.
    """
    out = Path(out)
    machine = build_machine(config.machine)
    require_grid_fits(config)
    require_possible_task(config, machine)
    _check_range(out, options.first, options.last)
    patterns = [pattern for spec in specs for pattern in spec.patterns]
    with open_run_folder(out, patterns) as folder, SecondProcess(out) as beside:
        _refuse_corrected(folder, specs)
        recompute = Stage.REGIONS in options.forced
        results = Results(config, machine, out, specs, recompute, options.proof, beside, given or {})
        run = _Run(folder, results, options, reporter or Quiet())
        if options.first is not None:
            run.require_earlier(options.first)
        outcomes = [run.run(stage) for stage in stages_up_to(specs, options.last)]
        run.report_missing_part(outcomes[-1])
        summary = run.prune_outdated()
        return RunReport(out, tuple(outcomes), summary, folder.superseded)


def _check_range(out: Path, first: Stage | None, last: Stage) -> None:
    if first is not None and first in last.later:
        raise UsageError(f"--from {first} comes after --to {last}: there is nothing to run")
    if first is not None and first.earlier and read_state(out) is None:
        raise UsageError(
            f"--from {first} needs earlier results, and there are none in {out}.\n"
            "  What to change: omit --from, or give the folder of an earlier run with --out."
        )


def _refuse_corrected(folder: RunFolder, specs: Specs) -> None:
    """Keep a corrected motion from being replaced, unasked, by one that is planned."""
    record = folder.state.stages.get(Stage.REFINE)
    if record is not None and CORRECTION in record.summary and spec_of(specs, Stage.REFINE).upstream:
        raise UsageError(
            f"{folder.path} has a motion that was corrected for another machine, which a run would replace by one that "
            "it plans.\n  What to change: give another folder (--out); gantry-tau correct proves and times it again "
            "(--following: also for drives that are off)."
        )


class _Run:
    """A run in progress."""

    def __init__(self, folder: RunFolder, results: Results, options: RunOptions, reporter: Reporter) -> None:
        self._folder = folder
        self._results = results
        self._options = options
        self._reporter = reporter
        self._specs = results.specs
        self._config = results.config
        self._config_yaml = dump_config(results.config)

    @property
    def _records(self) -> Mapping[Stage, Record]:
        return self._folder.state.stages

    def require_earlier(self, first: Stage) -> None:
        """Require results before `first` that belong to this configuration."""
        for stage in first.earlier:
            if why := self._why_outdated(stage):
                raise UsageError(
                    f"--from {first} needs the result of {stage}, which {why}.\n"
                    f"  What to change: omit --from, or run up to there first, with --to {first.earlier[-1]}."
                )

    def run(self, stage: Stage) -> Outcome:
        """Run a stage unless its result is up to date; stop the run at a result that is withheld."""
        if stage not in self._options.forced and not self._why_outdated(stage):
            outcome: Literal["done", "unchanged"] = "unchanged"
            record = self._records[stage]
            self._reporter.end(stage, outcome, record.seconds)
        else:
            outcome, record = "done", self._make(stage)
        if self._results.beside is not None:
            self._results.beside.done(stage)
        if not self._options.unproven and (error := spec_of(self._specs, stage).withheld(record.summary)):
            self.prune_outdated()
            files = ", ".join(str(self._folder.path / name) for name in record.files)
            error.add_note(f"What was found is kept, marked as {record.summary['status']}: {files}")
            raise error
        return Outcome(stage, outcome, record.seconds, record.summary)

    def report_missing_part(self, last: Outcome) -> None:
        """Write a report of a run that ends with a result of which a part is missing; a whole run has one anyway."""
        if failed_part(last.section) is not None and (page := self._failure_page()):
            self._commit(self._records, {failure_report(last.stage): page}, [])

    def prune_outdated(self) -> dict[str, Any]:
        """Move away what does not belong to this configuration; return the summary."""
        return self._commit(self._records, {}, [])

    def _why_outdated(self, stage: Stage) -> str:
        wanted = self._results.config_to_prove
        return why_outdated(self._specs, stage, wanted, self._records, self._folder.path)

    def _make(self, stage: Stage) -> Record:
        expected = expected_fingerprint(self._specs, stage, self._results.config_to_prove, self._records)
        monitor = Monitor(self._reporter.begin(stage), self._options.verbose)
        began = time.perf_counter()
        self._begin_beside(stage)
        try:
            product = spec_of(self._specs, stage).make(self._results, monitor)
        except (ConfigError, UsageError):
            raise
        except PipelineError as error:
            failure = self._fail(stage, error, expected, time.perf_counter() - began, monitor)
            self._reporter.end(stage, "failed", time.perf_counter() - began)
            raise failure from error.__cause__
        seconds = time.perf_counter() - began
        record = _record(expected, "done", seconds, product)
        self._replace(stage, record, product.files, product.completed)
        self._reporter.end(stage, "done", seconds)
        return record

    def _begin_beside(self, stage: Stage) -> None:
        """Begin with a later stage in a second process, which knows no stages but the usual ones."""
        beside, wanted = self._results.beside, (*self._options.last.earlier, self._options.last)
        if beside is None or self._specs is not SPECS:
            return
        if any(stage in spec.beside for spec in SPECS if spec.stage in wanted):
            beside.begin(self._config)

    def _fail(
        self, stage: Stage, error: PipelineError, expected: str, seconds: float, monitor: Monitor
    ) -> PipelineError:
        """Record a failure first, then again with its diagnosis, so that an interrupted diagnosis loses nothing.

        Returns the failure with the advice of the diagnosis, where there is one.
        """
        product = failure_product(self._config, stage, error, seconds, None)
        self._replace(stage, _record(expected, "failed", seconds, product), product.files)
        found = self._diagnose(stage, error, monitor)
        if found is not None:
            error = error.with_advice(found.advice) if isinstance(error, NoSolutionError) else error
            product = failure_product(self._config, stage, error, seconds, found)
            records = {**self._records, stage: _record(expected, "failed", seconds, product)}
            self._commit(records, product.files, [])
        details = self._folder.path / failure_names(stage)[0]
        note = f"Details of the failure are in {details}"
        if stage is not Stage.FIGURES and (page := self._failure_page()):
            self._commit(self._records, {failure_report(stage): page}, [])
            note += f"; a report of the run so far is in {self._folder.path / failure_report(stage)}"
        error.add_note(note)
        return error

    def _diagnose(self, stage: Stage, error: PipelineError, monitor: Monitor) -> Diagnosis | None:
        """Find out what prevents a solution; an interrupt ends the diagnosis only."""
        explain = spec_of(self._specs, stage).explain
        if explain is None or not self._options.why_not or not is_proven_infeasible(error):
            return None
        reason = error.reason if isinstance(error, NoSolutionError) else str(error)
        monitor.progress(f"{reason}. Finding out what prevents it; Ctrl-C ends that")
        try:
            found = explain(self._results, monitor)
        except KeyboardInterrupt:
            error.add_note("Why not: interrupted before anything was tried; run again to find out what prevents it.")
            return None
        error.add_note(found.note)
        error.add_note(f"A picture of what can be reached is in {self._folder.path / failure_picture(stage)}")
        return found

    def _failure_page(self) -> bytes | None:
        """Make a report of the run so far; None if it cannot be made, which is not a failure of the run."""
        try:
            return report_of(self._specs)(self._results, self._folder.state)
        except PipelineError:
            return None

    def _replace(
        self, stage: Stage, record: Record, files: Mapping[str, bytes], completed: Mapping[str, bytes] | None = None
    ) -> None:
        """Replace the record and the files of a stage, and files of earlier stages that it completes."""
        records = {one: _with_files(earlier, completed or {}) for one, earlier in self._records.items()}
        self._commit({**records, stage: record}, {**files, **(completed or {})}, self._existing(stage))

    def _existing(self, stage: Stage) -> list[str]:
        path, patterns = self._folder.path, spec_of(self._specs, stage).patterns
        if self._folder.damaged:
            return existing_files(path, patterns)
        recorded = self._records[stage].files if stage in self._records else ()
        return own_files(path, patterns, recorded)

    def _commit(
        self, records: Mapping[Stage, Record], files: Mapping[str, bytes], superseded: list[str]
    ) -> dict[str, Any]:
        """Change the folder in one step: results whose records no longer match go with the superseded files."""
        kept = matching_records(self._specs, self._config, records)
        for spec in self._specs:
            if spec.stage not in kept:
                superseded = superseded + self._existing(spec.stage)
        sections = {spec.section: spec.in_summary(_section(kept, spec.stage)) for spec in self._specs}
        summary = summarise(self._config, sections)
        state = State(config_sha256=config_sha256(self._config), stages=kept)
        self._folder.change(state, files, superseded, self._config_yaml, summary)
        return summary


def _section(records: Mapping[Stage, Record], stage: Stage) -> dict[str, Any] | None:
    return records[stage].summary if stage in records else None


def _with_files(record: Record, completed: Mapping[str, bytes]) -> Record:
    """Record those of some files that a stage has anyway as they are now."""
    own = {name: content for name, content in completed.items() if name in record.files}
    hashes = {name: sha256(content).hexdigest() for name, content in own.items()}
    sizes = {name: len(content) for name, content in own.items()}
    return record.model_copy(update={"files": {**record.files, **hashes}, "sizes": {**record.sizes, **sizes}})


def _record(fingerprint: str, status: Literal["done", "failed"], seconds: float, product: Product) -> Record:
    return Record(
        fingerprint=fingerprint,
        status=status,
        seconds=seconds,
        files={name: sha256(content).hexdigest() for name, content in product.files.items()},
        sizes={name: len(content) for name, content in product.files.items()},
        summary=jsonable({**product.section, "seconds": seconds}),
    )
