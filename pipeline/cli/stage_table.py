"""What a run did, as a short table: each stage, how it went, and its key figures in words."""

from rich.table import Table

from pipeline.run import RunReport
from pipeline.summary.sections import failed_part
from pipeline.summary.wording import key_figures

_UNCHANGED = "unchanged"


def stage_table(report: RunReport) -> Table:
    """Tabulate the stages of a run."""
    table = Table(title=f"{report.summary['name']}: what was done", title_justify="left")
    table.add_column("stage")
    table.add_column("status")
    table.add_column("seconds", justify="right")
    table.add_column("key figures")
    for outcome in report.outcomes:
        status = str(outcome.section["status"])
        if failed_part(outcome.section):
            status += " in part"
        if outcome.outcome == _UNCHANGED:
            status += f", {_UNCHANGED}"
        table.add_row(outcome.stage, status, f"{outcome.seconds:.1f}", key_figures(outcome.stage, outcome.section))
    return table
