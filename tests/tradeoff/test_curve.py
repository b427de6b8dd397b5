"""The points of a trade-off: every route and weight, and what is missing."""

from dataclasses import replace

import numpy as np
import pytest

from pipeline.config import Config
from pipeline.config.file import parse_config
from pipeline.errors import NoSolutionError
from pipeline.machine import build_machine
from pipeline.progress import Monitor
from pipeline.refine.result import Refinement
from pipeline.route.result import Route
from pipeline.tradeoff.curve import Stages, collect, trade_off


def test_every_route_has_a_point_without_time_and_one_for_every_weight(stages: Stages) -> None:
    """In the order of routes and weights; what has no proof is missing, and says why."""
    found = collect(stages, (3.0, 0.3), 2)
    assert [(point.route, point.weight) for point in found.points] == [
        (1, None),
        (1, 3.0),
        (1, 0.3),
        (2, None),
        (2, 3.0),
    ]
    assert [(one.route, one.weight, one.error.stage) for one in found.missing] == [(2, 0.3, "certify")]


def test_there_are_no_routes_after_one_that_does_not_exist(stages: Stages) -> None:
    """Ten routes are asked for, two exist: the third is missing, and nothing is said of the others."""
    messages: list[str] = []
    found = collect(stages, (3.0,), 10, Monitor(lambda message, fraction=None: messages.append(message)))
    assert len(found.points) == 4
    assert [(one.route, one.weight, one.error.reason) for one in found.missing] == [(3, None, "there are 2 routes")]
    assert messages == ["alternative 1 of 10", "alternative 2 of 10", "alternative 3 of 10"]


def test_a_route_without_a_path_does_not_end_the_search(stages: Stages) -> None:
    """The other routes still have their points."""

    def refine(route: Route) -> Refinement:
        if route.objective == 101.0:
            raise NoSolutionError("refine", "no path", "another corridor")
        return stages.refine(route)

    found = collect(replace(stages, refine=refine), (3.0,), 2)
    assert [(point.route, point.weight) for point in found.points] == [(2, None), (2, 3.0)]
    assert [(one.route, one.weight, one.error.reason) for one in found.missing] == [(1, None, "no path")]


@pytest.mark.slow
def test_less_weight_is_faster_and_everything_is_certified(quick_config: Config) -> None:
    """A plain move: duration falls from point to point, and no sampled kappa is above its proven bound."""
    data = quick_config.model_dump(mode="json")
    data["task"]["goal"] = data["task"]["start"] | {"y_m": 0.5}
    data["refine"] |= {"kappa_max": 40.0, "check_points": 2_000, "nodes": 50, "coefficients": 22, "max_meshes": 1}
    data["retime"] |= {"jerk_pieces": 100}
    config = parse_config(data)
    found = trade_off(config, build_machine(config.machine), (3.0, 0.3))
    assert found.missing == ()
    durations = [point.duration_s for point in found.points]
    assert durations[-1] < durations[0]
    np.testing.assert_allclose(durations, sorted(durations, reverse=True), rtol=1e-6)  # solvers end within a tolerance
    assert all(point.kappa_max <= point.kappa_bound <= 40.0 for point in found.points)
    assert all(point.duration_s >= point.quality.least_time_s for point in found.points)
