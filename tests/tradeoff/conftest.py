"""Points that are made up, and stages that find them without solving anything."""

from dataclasses import replace

import pytest

from pipeline.errors import NoSolutionError
from pipeline.machine import Machine
from pipeline.refine.result import Refinement
from pipeline.retime import MotionQuality
from pipeline.route.result import Route
from pipeline.tradeoff import TradeoffPoint
from pipeline.tradeoff.curve import Stages
from tests.run.short_results import make_refinement, make_route


def make_point(route: int = 1, weight: float | None = None) -> TradeoffPoint:
    """Make a point: the less weight, the faster, and the larger kappa."""
    faster = 0.0 if weight is None else 1.0 / (1.0 + weight)
    quality = MotionQuality((0, 1, 0, 0, 0), (2, 3, 2, 1, 1), 6.0 - faster, (3.0, 2.0, 1.0, 1.0, 1.0))
    bound = 30.0 + 10.0 * faster
    return TradeoffPoint(
        route, weight, ("LLL", "RRR"), 6.0 - faster, 400.0 * (1.0 + faster), bound - 0.1, bound, 90, quality
    )


@pytest.fixture
def stages(machine: Machine) -> Stages:
    """Give stages for two routes; the second one has no proof for weights below one."""

    def route(rank: int) -> Route:
        if rank > 2:
            raise NoSolutionError("route", "there are 2 routes", "ask for fewer")
        return make_route(machine, 100.0 + rank)

    def refine(found: Route) -> Refinement:
        return replace(make_refinement(machine), iterations=int(found.objective))

    def speed_up(found: Route, refined: Refinement, weight: float) -> Refinement:
        assert refined.iterations == int(found.objective)
        return refined

    def measure(rank: int, weight: float | None, refined: Refinement) -> TradeoffPoint:
        if rank == 2 and weight is not None and weight < 1.0:
            raise NoSolutionError("certify", "kappa is too large", "raise refine.kappa_max")
        assert refined.iterations == 100 + rank
        return make_point(rank, weight)

    return Stages(route, refine, speed_up, measure)
