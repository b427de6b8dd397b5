"""The least that kappa has to reach on every path: floods for larger and larger K, as far as boxes last."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from pipeline.bound.chart import build_chart, chart_point, why_no_chart
from pipeline.bound.evaluate import Evaluator
from pipeline.bound.flood import Flood, Verdict, flood
from pipeline.bound.theorem import Theorem, apply_theorem
from pipeline.config import Config
from pipeline.config.choices import TiltAxis
from pipeline.errors import NoSolutionError
from pipeline.machine.geometry import Machine
from pipeline.progress import QUIET, Monitor
from pipeline.route.regions.endpoints import Endpoint

_FIRST, _STEP = (1.02, 1.05), 1.1
"""K by the larger kappa of start and goal at first, and the ratio of one K to the last from there on."""
_LARGEST = 1e6
"""Largest K that is tried."""
STAGE = "bound"


@dataclass(frozen=True, eq=False)
class Attempt:
    """A flood for one K: its verdict, the boxes it took, and how often they were halved on the cheapest ways."""

    kappa: float
    verdict: Verdict
    boxes: int
    rounds: int


@dataclass(frozen=True, eq=False)
class Bound:
    """What every path from start to goal has to do.

    Attributes
    ----------
    theorem : Theorem
        Whether no path exists at all.
    ends_kappa : float
        The larger kappa of start and goal, which every path has.
    kappa : float or None
        Every path within the limits has a larger kappa somewhere, or meets det H = 0; None if no flood proved more than
        the ends.
    attempts : tuple of Attempt
        The floods, in their order.
    flood : Flood or None
        That of the largest K proven.
    """

    theorem: Theorem
    ends_kappa: float
    kappa: float | None
    attempts: tuple[Attempt, ...]
    flood: Flood | None

    @property
    def least_kappa(self) -> float:
        """What kappa is at least, somewhere on every path within the limits."""
        return max(self.ends_kappa, self.kappa or 0.0)


def build_evaluator(config: Config, machine: Machine, ends: tuple[Endpoint, Endpoint], kappa: float) -> Evaluator:
    """Make what evaluates boxes of the task's chart.

    Raises
    ------
    NoSolutionError
        If the machine has no such chart; says why.
    """
    if reason := _why_no_boxes(config, machine):
        advice = "the theorem alone is for machines without tilt"
        if not machine.has_parallel_rails:
            advice = "leave out machine.rails.slopes: what is proven then is about parallel rails"
        raise NoSolutionError(STAGE, f"boxes do not cover this machine: {reason}", advice)
    tilts = (0.0 if axis in config.task.locked_axes else _above(config.task.tilt_max_deg) for axis in TiltAxis)
    rx, rz = tilts
    return Evaluator(build_chart(machine, (rx, rz), ends), ends[0].det_sign, kappa)


def bound_all_paths(
    config: Config, machine: Machine, ends: tuple[Endpoint, Endpoint], most_boxes: int, monitor: Monitor = QUIET
) -> Bound:
    """Prove what can be proven with so many boxes; that is what the ends have where boxes do not cover the machine."""
    return bound_paths(config, machine, ends, None, 0 if _why_no_boxes(config, machine) else most_boxes, monitor)


def bound_paths(
    config: Config,
    machine: Machine,
    ends: tuple[Endpoint, Endpoint],
    kappa: float | None = None,
    most_boxes: int = 300_000,
    monitor: Monitor = QUIET,
) -> Bound:
    """Prove how large kappa gets on every path: for one K, or for one after another as long as boxes last.

    Where the theorem excludes every path, no boxes are needed, and there are none unless a K is given.

    Raises
    ------
    NoSolutionError
        If boxes are needed, and the machine has no chart.
    """
    theorem = apply_theorem(config, machine, ends)
    at_ends = max(end.kappa for end in ends)
    attempts: list[Attempt] = []
    proven: tuple[float, Flood] | None = None
    left = most_boxes
    if kappa is not None and kappa < at_ends:
        return Bound(theorem, at_ends, kappa, (), None)
    for K in _climbing(at_ends) if kappa is None else (kappa,):
        if left <= 0 or (theorem.no_path and kappa is None):
            break
        evaluator = build_evaluator(config, machine, ends, K)
        points = [chart_point(evaluator.chart, end) for end in ends]
        found = flood(evaluator, points[0], points[1], left, _saying(monitor, K))
        attempts.append(Attempt(K, found.verdict, found.boxes.count, found.rounds))
        if found.verdict is not Verdict.NONE:
            break
        proven = K, found
        left -= found.boxes.count
    return Bound(theorem, at_ends, proven and proven[0], tuple(attempts), proven and proven[1])


def _why_no_boxes(config: Config, machine: Machine) -> str:
    return why_no_chart(machine, config.machine.links.l3c.length_m is None)


def _climbing(kappa: float) -> Iterator[float]:
    yield from (factor * kappa for factor in _FIRST)
    while (kappa := kappa * _STEP) < _LARGEST:
        yield kappa


def _saying(monitor: Monitor, K: float) -> Monitor:
    def progress(message: str, fraction: float | None = None) -> None:
        monitor.progress(f"kappa {K:.4g}: {message}", fraction)

    return Monitor(progress, monitor.verbose)


def _above(degrees: float) -> float:
    return float(np.nextafter(np.deg2rad(degrees), np.inf)) if degrees else 0.0
