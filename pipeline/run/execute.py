"""Running stages: which are up to date, which run again, and what becomes of old results."""

import time
from collections.abc import Iterator
from dataclasses import dataclass
from hashlib import sha256
from pathlib import Path
from typing import Any, Literal

from pipeline.artifacts import (
    Record,
    RunFolder,
    State,
    existing_files,
    failure_names,
    failure_picture,
    open_run_folder,
    plain,
    read_state,
)
from pipeline.artifacts.layout import failure_report
from pipeline.config import Config
from pipeline.config.file import config_sha256, dump_config
from pipeline.errors import ConfigError, NoSolutionError, PipelineError, UsageError
from pipeline.machine.geometry import build_machine
from pipeline.progress import Progress
from pipeline.route.regions.endpoints import task_endpoints
from pipeline.run.diagnosis import Diagnosis, can_diagnose, diagnose
from pipeline.run.fingerprint import UPSTREAM, fingerprint, fingerprints
from pipeline.run.reporter import Quiet, Reporter
from pipeline.run.reporting import page_of_failure
from pipeline.run.stages import MAKE, Product, Results
from pipeline.stage import STAGES, Stage
from pipeline.summary.sections import failed_part, failure_section, summarise

_SECTION = {
    Stage.REGIONS: "regions",
    Stage.ROUTE: "route",
    Stage.REFINE: "path",
    Stage.CERTIFY: "certificate",
    Stage.RETIME: "trajectory",
    Stage.FIGURES: "figures",
}
"""Where in the summary each stage's figures are."""


@dataclass(frozen=True)
class Outcome:
    """How a stage of a run went: its seconds and its part of the summary are of when it was last run."""

    stage: Stage
    outcome: Literal["done", "unchanged"]
    seconds: float
    section: dict[str, Any]


@dataclass(frozen=True)
class RunReport:
    """What a run did, and where its results are."""

    folder: Path
    outcomes: tuple[Outcome, ...]
    summary: dict[str, Any]

    def require_complete(self) -> None:
        """Insist on all parts of all results.

        Raises
        ------
        NoSolutionError
            When a part of a stage failed (the way back) though the stage has a result; says why.
        """
        for outcome in self.outcomes:
            part = failed_part(outcome.section)
            if part is not None:
                raise NoSolutionError(outcome.stage, part["reason"], part["advice"])


def run_pipeline(
    config: Config,
    out: Path | str,
    first: Stage | None = None,
    last: Stage | None = None,
    force: bool = False,
    reporter: Reporter | None = None,
    verbose: bool = False,
    why_not: bool = True,
    tolerances: bool = False,
) -> RunReport:
    """Run the stages whose inputs have changed, and write their results into the folder `out`.

    A part of a result may have failed, see `RunReport.require_complete`.

    Parameters
    ----------
    first : Stage, optional
        This stage and later ones run again in any case; earlier results must be there and up to date.
    last : Stage, optional
        Where to stop.
    force : bool
        All stages run again.
    verbose : bool
        Solvers write their logs to the terminal.
    why_not : bool
        Find out what stands in the way where no route exists; it is added to the error.
    tolerances : bool
        The proof searches calibration tolerances, too, whatever `certify.what` says.

    Raises
    ------
    ConfigError
        When the machine cannot be at the start or goal; nothing was touched.
    UsageError
        When the stages asked for make no range, or results they need are missing or outdated.
    NoSolutionError
        When a stage has no solution; why is kept in the run folder.
    """
    out, last = Path(out), last or STAGES[-1]
    machine = build_machine(config.machine)
    task_endpoints(config, machine)
    _check_range(out, first, last)
    with open_run_folder(out) as folder:
        forced = (first, *first.later) if first is not None else STAGES if force else ()
        results = Results(config, machine, out, anew=Stage.REGIONS in forced, tolerances=tolerances)
        run = _Run(config, folder, results, reporter or Quiet(), verbose, why_not)
        if first is not None:
            run.require_earlier(first)
        outcomes = [run.run(stage, again=stage in forced) for stage in (*last.earlier, last)]
        return RunReport(out, tuple(outcomes), run.settle())


def _check_range(out: Path, first: Stage | None, last: Stage) -> None:
    if first is not None and first in last.later:
        raise UsageError(f"--from {first} comes after --to {last}: there is nothing to run")
    if first is not None and first.earlier and read_state(out) is None:
        raise UsageError(
            f"--from {first} builds on earlier results, and there are none in {out}.\n"
            "  What to change: leave --from out, or name the folder of an earlier run with --out."
        )


class _Run:
    """One run at work in its folder."""

    def __init__(
        self,
        config: Config,
        folder: RunFolder,
        results: Results,
        reporter: Reporter,
        verbose: bool,
        why_not: bool,
    ) -> None:
        self._config = config
        self._config_yaml = dump_config(config)
        self._folder = folder
        self._results = results
        self._reporter = reporter
        self._verbose = verbose
        self._why_not = why_not

    def require_earlier(self, first: Stage) -> None:
        """Insist on results before `first` that belong to this configuration."""
        for stage in first.earlier:
            if trouble := self._trouble(stage):
                raise UsageError(
                    f"--from {first} builds on the result of {stage}, which {trouble}.\n"
                    f"  What to change: leave --from out, or run up to there first, with --to {first.earlier[-1]}."
                )

    def run(self, stage: Stage, again: bool) -> Outcome:
        """Run a stage unless its result is up to date."""
        if not again and not self._trouble(stage):
            record = self._folder.state.stages[stage]
            self._reporter.end(stage, "unchanged", record.seconds)
            return Outcome(stage, "unchanged", record.seconds, record.summary)
        record = self._make(stage)
        return Outcome(stage, "done", record.seconds, record.summary)

    def settle(self) -> dict[str, Any]:
        """Leave nothing in the folder that does not belong to this configuration; return the summary."""
        return self._commit(self._folder.state.stages, {}, [])

    def _trouble(self, stage: Stage) -> str:
        """Say what is wrong with the result of a stage; nothing where it is up to date."""
        record = self._folder.state.stages.get(stage)
        if record is None:
            return "has not been run here"
        if record.status == "failed":
            return "failed"
        if record.fingerprint not in self._accepted(self._results.asked, stage, self._folder.state.stages):
            return "was run with another configuration, version or earlier result"
        if damage := record.damage(self._folder.path):
            return f"has files that were removed or changed since ({', '.join(damage)})"
        return ""

    def _accepted(self, config: Config, stage: Stage, records: dict[Stage, Record]) -> list[str]:
        """Fingerprints that a stage's result may have with these results before it; none where one is missing."""
        known = self._known(stage, records)
        return [] if known is None else fingerprints(config, stage, known)

    def _known(self, stage: Stage, records: dict[Stage, Record]) -> dict[Stage, str] | None:
        """Hashes of what a stage builds on; None where some of it is missing."""
        upstream = {name: records.get(name) for name in UPSTREAM[stage]}
        known = {
            name: record.result_sha256(name)
            for name, record in upstream.items()
            if record is not None and record.status == "done"
        }
        return known if len(known) == len(upstream) else None

    def _make(self, stage: Stage) -> Record:
        known = self._known(stage, self._folder.state.stages)
        assert known is not None, "stages run in order, and a failed one ends the run"
        expected = fingerprint(self._results.asked, stage, known)
        progress = self._reporter.begin(stage)
        began = time.perf_counter()
        try:
            product = MAKE[stage](self._results, progress, self._verbose)
        except (ConfigError, UsageError):
            raise
        except PipelineError as error:
            self._fail(stage, error, expected, time.perf_counter() - began, progress)
            self._reporter.end(stage, "failed", time.perf_counter() - began)
            raise
        seconds = time.perf_counter() - began
        record = self._record(expected, "done", seconds, product)
        self._replace(stage, record, product.files)
        self._reporter.end(stage, "done", seconds)
        return record

    def _fail(self, stage: Stage, error: PipelineError, expected: str, seconds: float, progress: Progress) -> None:
        """Keep a failure, and then once more with why: whatever becomes of looking for that, the failure is kept."""
        self._keep_failure(stage, error, expected, seconds)
        found = self._diagnose(stage, error, progress)
        if found is not None:
            self._keep_failure(stage, error, expected, seconds, found)
        kept = f"What is known about it was kept in {self._folder.path / failure_names(stage)[0]}"
        if page := page_of_failure(self._results, self._folder.state):
            self._commit(self._folder.state.stages, {failure_report(stage): page}, [])
            kept += f"; what there is of the run is shown in {self._folder.path / failure_report(stage)}"
        error.add_note(kept)

    def _diagnose(self, stage: Stage, error: PipelineError, progress: Progress) -> Diagnosis | None:
        """Find out what stands in the way of a route; who does not want to wait for it interrupts that alone."""
        if not self._why_not or not can_diagnose(stage, error):
            return None
        reason = error.reason if isinstance(error, NoSolutionError) else str(error)
        progress(f"{reason}. Looking for what stands in the way; Ctrl-C ends that")
        try:
            found = diagnose(self._results, progress)
        except KeyboardInterrupt:
            error.add_note("Why not: interrupted; run again to look for what stands in the way.")
            return None
        error.add_note(found.note)
        error.add_note(f"What can be reached is shown in {self._folder.path / failure_picture(stage)}")
        return found

    def _keep_failure(
        self, stage: Stage, error: PipelineError, expected: str, seconds: float, found: Diagnosis | None = None
    ) -> None:
        """Keep what is known of a failure for diagnosis, under names that no result has.

        With what was found out about it, it takes the place of the failure just kept.
        """
        from pipeline.artifacts.results import failure_files

        reason, advice, diagnosis = str(error), "", {}
        if isinstance(error, NoSolutionError):
            reason, advice, diagnosis = error.reason, error.advice, error.diagnosis
        facts: dict[str, Any] = {"stage": stage, "reason": reason, "advice": advice, "seconds": seconds}
        facts["config_sha256"] = config_sha256(self._config)
        if found is not None:
            facts["why_not"] = found.facts
        section = failure_section(reason, advice, str(diagnosis.get("status", "failed")))
        product = Product(failure_files(stage, facts, diagnosis, found.picture if found else None), section)
        record = self._record(expected, "failed", seconds, product)
        superseded = existing_files(self._folder.path, stage) if found is None else []
        self._commit({**self._folder.state.stages, stage: record}, product.files, superseded)

    def _record(self, expected: str, status: Literal["done", "failed"], seconds: float, product: Product) -> Record:
        return Record(
            fingerprint=expected,
            status=status,
            seconds=seconds,
            files={name: sha256(content).hexdigest() for name, content in product.files.items()},
            summary=plain({**product.section, "seconds": seconds}),
        )

    def _replace(self, stage: Stage, record: Record, files: dict[str, bytes]) -> None:
        """Put the record and files of a stage in the place of what was there."""
        self._commit({**self._folder.state.stages, stage: record}, files, existing_files(self._folder.path, stage))

    def _commit(self, records: dict[Stage, Record], files: dict[str, bytes], superseded: list[str]) -> dict[str, Any]:
        """Change the folder at once: what no longer fits the records before it goes."""
        kept = dict(self._fitting(records))
        for stage in STAGES:
            if stage not in kept:
                superseded = superseded + existing_files(self._folder.path, stage)
        summary = summarise(self._config, {_SECTION[stage]: record.summary for stage, record in kept.items()})
        state = State(config_sha256=config_sha256(self._config), stages=kept)
        self._folder.change(state, files, superseded, self._config_yaml, summary)
        return summary

    def _fitting(self, records: dict[Stage, Record]) -> Iterator[tuple[Stage, Record]]:
        """Go through the records in order, leaving out those that no longer fit what they build on."""
        kept: dict[Stage, Record] = {}
        for stage in STAGES:
            record = records.get(stage)
            if record is not None and record.fingerprint in self._accepted(self._config, stage, kept):
                kept[stage] = record
                yield stage, record
