"""A run: all stages in order, each only if something it depends on has changed."""

from pipeline.run.execute import run_pipeline
from pipeline.run.options import RunOptions
from pipeline.run.reading import open_results
from pipeline.run.reporter import Quiet, Reporter
from pipeline.run.results import Results
from pipeline.run.run_report import Outcome, RunReport
from pipeline.stage import Stage

__all__ = [
    "Outcome",
    "Quiet",
    "Reporter",
    "Results",
    "RunOptions",
    "RunReport",
    "Stage",
    "open_results",
    "run_pipeline",
]
