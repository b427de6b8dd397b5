"""Why there is no route: computed once that is proven, as text, as numbers and as a picture."""

import time
from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING, Any

from pipeline.progress import Monitor

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from pipeline.route.diagnosis.result import InfeasibilityReport
    from pipeline.run.results import Results


@dataclass(frozen=True, eq=False)
class Diagnosis:
    """Why there is no route: for the terminal, for the file of the failure, and as a picture."""

    note: str
    facts: dict[str, Any]
    picture: "Figure"


def diagnose(results: "Results", monitor: Monitor) -> Diagnosis:
    """Find out how far each limit has to give, one at a time, and draw what can be reached."""
    from pipeline.figures.maps.reach import reach_figure
    from pipeline.route.diagnosis.search import explain_infeasibility

    began = time.perf_counter()
    found = explain_infeasibility(results.config, results.machine, results.regions, monitor)
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
    """Write everything in lines, first the changes that open a route."""
    opening = [finding.sentence for finding in found.opening]
    others = [finding.sentence for finding in found.findings if finding not in found.opening]
    lines = [f"Reach: {reach}", *found.remarks, "One limit at a time, everything else as configured:"]
    return "\n    ".join(["Why not:", *lines, *(f"- {sentence}" for sentence in opening + others)])
