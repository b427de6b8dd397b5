"""Why there is no route: computed once that is proven, as text, as numbers and as a picture."""

import time
from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING, Any

from pipeline.progress import Monitor

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from pipeline.route.diagnosis.result import InfeasibilityReport
    from pipeline.run.results import Results

_OF_THE_GRID = (
    '"no route" is proven for this grid and its moves, not for all paths; what no path can do: gantry-tau bound CONFIG'
)


@dataclass(frozen=True, eq=False)
class Diagnosis:
    """Why there is no route: for the terminal, for the file of the failure, and as a picture.

    `advice` is what to change, of what was tried.
    """

    note: str
    advice: str
    facts: dict[str, Any]
    picture: "Figure"


def diagnose(results: "Results", monitor: Monitor) -> Diagnosis:
    """Find out what has to give, one thing at a time, and draw what can be reached; Ctrl-C keeps what was found."""
    from pipeline.bound.theorem import apply_theorem
    from pipeline.figures.maps.reach import reach_figure
    from pipeline.route.diagnosis.search import explain_infeasibility
    from pipeline.route.regions.endpoints import task_endpoints

    began = time.perf_counter()
    found = explain_infeasibility(results.config, results.machine, results.regions, monitor)
    picture = reach_figure(results.config, results.regions, found.from_start, found.to_goal)
    reach = found.reach(results.regions)
    theorem = apply_theorem(results.config, results.machine, task_endpoints(results.config, results.machine))
    continuum = theorem.sentence if theorem.no_path else _OF_THE_GRID
    facts = {
        "reach": reach,
        "continuum": continuum,
        "remarks": found.remarks,
        "not_tried": found.not_tried,
        "findings": [{"sentence": finding.sentence, **asdict(finding)} for finding in found.findings],
        "seconds": time.perf_counter() - began,
    }
    return Diagnosis(_note(found, reach, continuum), found.advice, facts, picture)


def _note(found: "InfeasibilityReport", reach: str, continuum: str) -> str:
    """Write everything in lines, first the changes that open a route."""
    opening = [finding.sentence for finding in found.opening]
    others = [finding.sentence for finding in found.findings if finding not in found.opening]
    lines = [
        f"Reach: {reach}",
        f"Without the grid: {continuum}",
        *found.remarks,
        "One change at a time, everything else as configured:",
    ]
    lines += [f"- {sentence}" for sentence in opening + others]
    if found.not_tried:
        lines.append(f"Interrupted; not tried: {', '.join(found.not_tried)}")
    return "\n    ".join(["Why not:", *lines])
