"""Why a route does not exist: computed when the search has proven it, told in words, kept as numbers and a picture."""

import time
from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING, Any

from pipeline.errors import NoSolutionError, PipelineError
from pipeline.progress import Progress
from pipeline.run.stages import Results
from pipeline.stage import Stage
from pipeline.status import Status

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from pipeline.route.diagnosis.result import InfeasibilityReport


@dataclass(frozen=True, eq=False)
class Diagnosis:
    """What is known of a missing route: for the terminal, for the file of the failure, and to look at."""

    note: str
    facts: dict[str, Any]
    picture: "Figure"


def can_diagnose(stage: Stage, error: PipelineError) -> bool:
    """Tell whether a failure is a proof that no route exists, and not a limit of time, or of other routes."""
    if stage is not Stage.ROUTE or not isinstance(error, NoSolutionError):
        return False
    return error.diagnosis.get("status") == Status.INFEASIBLE and not error.diagnosis.get("routes")


def diagnose(results: Results, progress: Progress) -> Diagnosis:
    """Find out how far each limit has to give, one at a time, and draw what can be reached."""
    from pipeline.figures.maps.reach import reach_figure
    from pipeline.route.diagnosis.search import explain_infeasibility

    began = time.perf_counter()
    found = explain_infeasibility(results.config, results.machine, results.regions, progress)
    picture = reach_figure(results.config, results.regions, found.from_start, found.to_goal)
    reach = found.reach(results.regions)
    facts = {
        "reach": reach,
        "remarks": found.remarks,
        "findings": [{"sentence": finding.sentence, **asdict(finding)} for finding in found.findings],
        "seconds": time.perf_counter() - began,
    }
    return Diagnosis(_note(found, reach), facts, picture)


def _note(found: "InfeasibilityReport", reach: str) -> str:
    """Tell everything in lines, what opens a route first."""
    opening = [finding.sentence for finding in found.opening]
    others = [finding.sentence for finding in found.findings if finding not in found.opening]
    lines = [f"Reach: {reach}", *found.remarks, "One limit at a time, all else as configured:"]
    return "\n    ".join(["Why not:", *lines, *(f"- {sentence}" for sentence in opening + others)])
