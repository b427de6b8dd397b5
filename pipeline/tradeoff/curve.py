"""The trade-off of a task: for each of its best routes, the least integral of kappa and faster motions, all certified.

Every point minimises T / T_ref + w K / K_ref over path and time law (`refine.objective: time`), for one weight w =
`refine.time_weight`; the less w, the faster the motion and the larger kappa. All weights of a route start from the same
refined path, which is the point without a weight.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from pipeline.certify import certify_path
from pipeline.compare.motion import common_retiming, retimed
from pipeline.config import Config
from pipeline.config.choices import PathObjective, Proof
from pipeline.errors import NoSolutionError
from pipeline.machine.geometry import Machine
from pipeline.progress import QUIET, Monitor
from pipeline.refine import measure_path, refine_path, sample_path
from pipeline.refine.problem import build_problem
from pipeline.refine.result import Refinement
from pipeline.refine.timed.minimise import minimise_time
from pipeline.retime import MotionQuality, measure_quality
from pipeline.route import build_regions, plan_route
from pipeline.route.metric import step_sizes
from pipeline.route.result import Route

WEIGHTS = (10.0, 3.0, 1.0, 0.3, 0.1)
"""Weights of the integral of kappa by default: from almost the least integral to almost the least duration."""


@dataclass(frozen=True)
class TradeoffPoint:
    """A certified motion at full speed, without waiting.

    Attributes
    ----------
    route : int
        Rank of its route, `route.alternative`: 1 is the best.
    weight : float or None
        Weight of the integral of kappa (`refine.time_weight`); None for the path that does not consider time.
    modes : tuple of str
        Working modes in their order.
    duration_s, kappa_integral, kappa_max : float
        What is traded off: the duration before it is fitted to whole periods, the integral in steps of the route's
        metric, the largest kappa at samples.
    kappa_bound : float
        Proven bound of kappa along the whole path.
    boxes : int
        Boxes of the certificate.
    quality : MotionQuality
        Sign changes, and the duration against the least one.
    """

    route: int
    weight: float | None
    modes: tuple[str, ...]
    duration_s: float
    kappa_integral: float
    kappa_max: float
    kappa_bound: float
    boxes: int
    quality: MotionQuality


@dataclass(frozen=True)
class MissingPoint:
    """A point, or a whole route (without a weight), that has no solution or no proof, and why."""

    route: int
    weight: float | None
    error: NoSolutionError


@dataclass(frozen=True)
class Tradeoff:
    """The points of all routes, those of a route in the order of the weights, and those that are missing."""

    points: tuple[TradeoffPoint, ...]
    missing: tuple[MissingPoint, ...]


@dataclass(frozen=True)
class Stages:
    """What finds the points; tests put simpler functions in their place.

    Attributes
    ----------
    routes : function
        Finds the route of a rank.
    refine : function
        Finds the path of a route that does not consider time.
    speed_up : function
        Finds the motion for a weight, beginning with that path.
    measure : function
        Proves and times a path: a point of a route and a weight.
    """

    routes: Callable[[int], Route]
    refine: Callable[[Route], Refinement]
    speed_up: Callable[[Route, Refinement, float], Refinement]
    measure: Callable[[int, float | None, Refinement], TradeoffPoint]


def trade_off(
    config: Config, machine: Machine, weights: Sequence[float] = WEIGHTS, routes: int = 1, monitor: Monitor = QUIET
) -> Tradeoff:
    """Find the motions for all weights along each of the best routes; the cap on kappa is `refine.kappa_max`.

    Raises
    ------
    ConfigError
        If a pose or a direction of the task is impossible.
    NoSolutionError
        If there is no region at the start or the goal.
    """
    return collect(_stages(config, machine, monitor), weights, routes, monitor)


def collect(stages: Stages, weights: Sequence[float], routes: int, monitor: Monitor = QUIET) -> Tradeoff:
    """Find the points of all routes; a route that does not exist ends the search, a point without proof does not."""
    found: list[TradeoffPoint | MissingPoint] = []
    for rank in range(1, routes + 1):
        monitor.progress(f"alternative {rank} of {routes}", (rank - 1) / routes)
        try:
            route = stages.routes(rank)
        except NoSolutionError as error:
            found.append(MissingPoint(rank, None, error))
            break
        found += _points_of(stages, rank, route, weights)
    return Tradeoff(
        tuple(one for one in found if isinstance(one, TradeoffPoint)),
        tuple(one for one in found if isinstance(one, MissingPoint)),
    )


def _points_of(
    stages: Stages, rank: int, route: Route, weights: Sequence[float]
) -> Iterator[TradeoffPoint | MissingPoint]:
    try:
        refined = stages.refine(route)
    except NoSolutionError as error:
        yield MissingPoint(rank, None, error)
        return
    for weight in (None, *weights):
        try:
            path = refined if weight is None else stages.speed_up(route, refined, weight)
            yield stages.measure(rank, weight, path)
        except NoSolutionError as error:
            yield MissingPoint(rank, weight, error)


def _stages(config: Config, machine: Machine, monitor: Monitor) -> Stages:
    monitor.progress("regions")
    table = build_regions(config, machine, monitor)

    def route(rank: int) -> Route:
        return plan_route(_changed(config, "route", alternative=rank), machine, table, monitor)

    def refine(route: Route) -> Refinement:
        plain = _changed(config, "refine", objective=PathObjective.INTEGRAL)
        return refine_path(plain, machine, route, monitor)

    def speed_up(route: Route, refined: Refinement, weight: float) -> Refinement:
        timed = _changed(config, "refine", objective=PathObjective.TIME, time_weight=weight)
        return minimise_time(build_problem(timed, machine, route, monitor), refined)

    def measure(rank: int, weight: float | None, refined: Refinement) -> TradeoffPoint:
        return measured(config, machine, refined, (rank, weight), monitor)

    return Stages(route, refine, speed_up, measure)


def measured(
    config: Config, machine: Machine, refined: Refinement, name: tuple[int, float | None], monitor: Monitor = QUIET
) -> TradeoffPoint:
    """Prove and time a path, and put it in numbers; `name` is the rank of its route and its weight.

    Raises
    ------
    NoSolutionError
        If the path cannot be certified or timed.
    """
    path = refined.path
    certificate = certify_path(_changed(config, "certify", what=Proof.PATH), machine, path, monitor)
    assert certificate.bounds is not None, "a certified path has boxes"
    trajectory = retimed(config, common_retiming(config), path)
    samples = sample_path(path, np.linspace(0.0, 1.0, config.refine.check_points))
    figures, timing = measure_path(samples, step_sizes(config.route)), trajectory.timing
    assert timing is not None, "a motion that was just planned has a report"
    return TradeoffPoint(
        route=name[0],
        weight=name[1],
        modes=figures.modes,
        duration_s=timing.motion_s,
        kappa_integral=figures.kappa_integral,
        kappa_max=figures.kappa_max,
        kappa_bound=certificate.bounds.kappa,
        boxes=len(certificate.chain.boxes),
        quality=measure_quality(trajectory),
    )


def _changed(config: Config, section: str, **keys: object) -> Config:
    return config.model_copy(update={section: getattr(config, section).model_copy(update=keys)})
