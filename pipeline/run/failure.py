"""What is kept of a stage that failed."""

from typing import Any

from pipeline.config import Config
from pipeline.config.file import config_sha256
from pipeline.errors import InfeasibleError, NoSolutionError, PipelineError
from pipeline.run.diagnosis import Diagnosis
from pipeline.run.product import Product
from pipeline.stage import Stage
from pipeline.summary.section import failure_section


def is_proven_infeasible(error: PipelineError) -> bool:
    """Check whether a failure proves that there is no solution, rather than too little time or too few routes."""
    return isinstance(error, InfeasibleError) and not error.diagnosis.get("routes")


def failure_product(
    config: Config, stage: Stage, error: PipelineError, seconds: float, found: Diagnosis | None
) -> Product:
    """Make the files and the summary of a failure, with its diagnosis if there is one."""
    from pipeline.artifacts.results.failure import failure_files

    reason, advice, details = str(error), "", {}
    if isinstance(error, NoSolutionError):
        reason, advice, details = error.reason, error.advice, error.diagnosis
    facts: dict[str, Any] = {"stage": stage, "reason": reason, "advice": advice, "seconds": seconds}
    facts["config_sha256"] = config_sha256(config)
    if found is not None:
        facts["why_not"] = found.facts
    section = failure_section(reason, advice, str(details.get("status", "failed")))
    if found is not None:
        section["why_not"] = [line.strip() for line in found.note.splitlines()[1:]]
    return Product(failure_files(stage, facts, details, found.picture if found else None), section)
