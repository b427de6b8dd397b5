"""What a run did, as a short table: each stage, its status, and its key figures in words."""

from typing import TYPE_CHECKING

from rich.table import Table

if TYPE_CHECKING:
    from pipeline.run import RunReport
    from pipeline.run.stage_specs import Specs

_UNCHANGED = "unchanged"


def stage_table(report: "RunReport", specs: "Specs") -> Table:
    """Tabulate the stages of a run."""
    from pipeline.run.stage_specs import spec_of

    table = Table(title=f"{report.summary['name']}: stages", title_justify="left")
    table.add_column("stage")
    table.add_column("status")
    table.add_column("seconds", justify="right")
    table.add_column("key figures")
    for outcome in report.outcomes:
        status = str(outcome.section["status"])
        if outcome.outcome == _UNCHANGED:
            status += f", {_UNCHANGED}"
        words = spec_of(specs, outcome.stage).words(outcome.section)
        table.add_row(outcome.stage, status, f"{outcome.seconds:.1f}", words)
    return table
