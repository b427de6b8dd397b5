"""A run: all stages in order, each only when what it depends on has changed."""

from pipeline.run.execute import Outcome, RunReport, run_pipeline
from pipeline.run.reading import open_results
from pipeline.run.reporter import Quiet, Reporter
from pipeline.run.stages import Results
from pipeline.stage import Stage

__all__ = ["Outcome", "Quiet", "Reporter", "Results", "RunReport", "Stage", "open_results", "run_pipeline"]
