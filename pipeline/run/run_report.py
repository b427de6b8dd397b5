"""What a run did."""

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

from pipeline.artifacts.layout import REPORT, SUMMARY, failure_report
from pipeline.errors import NoSolutionError
from pipeline.run.stage_specs import SPECS, Specs, spec_of
from pipeline.stage import Stage
from pipeline.summary.section import Section, failed_part


@dataclass(frozen=True)
class Outcome:
    """How a stage of a run ended; seconds and section are from when it last ran."""

    stage: Stage
    outcome: Literal["done", "unchanged"]
    seconds: float
    section: Section


@dataclass(frozen=True)
class RunReport:
    """What a run did, and where its results are; where it moved outdated files without a successor, and their names."""

    folder: Path
    outcomes: tuple[Outcome, ...]
    summary: dict[str, Any]
    superseded: tuple[Path, tuple[str, ...]] | None = None

    def require_complete(self) -> None:
        """Require all parts of all results.

        Raises
        ------
        NoSolutionError
            When a part of a stage failed (the way back) although the stage has a result; says why.
        """
        for outcome in self.outcomes:
            part = failed_part(outcome.section)
            if part is not None:
                error = NoSolutionError(outcome.stage, part["reason"], part["advice"])
                pages = (self.folder / name for name in (REPORT, failure_report(outcome.stage)))
                if page := next((page for page in pages if page.exists()), None):
                    error.add_note(f"A report of the run is in {page}")
                raise error


def files_to_open(folder: Path, stages: Iterable[Stage], specs: Specs = SPECS) -> list[tuple[Path, str]]:
    """List the files worth opening after stages have run, and what they are."""
    known = [shown for stage in stages for shown in spec_of(specs, stage).shown]
    found = [(folder / name, what) for name, what in (*known, (SUMMARY, "all figures of this run as numbers"))]
    return [(path, what) for path, what in found if path.exists()]
