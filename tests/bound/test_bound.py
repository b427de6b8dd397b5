"""Tests of bounds: what is proven, and what is never proven."""

from collections.abc import Callable
from typing import Any

import pytest

from pipeline.bound.bound import bound_all_paths, bound_paths
from pipeline.bound.flood import Verdict
from pipeline.config import Config
from pipeline.errors import NoSolutionError
from pipeline.machine.geometry import Machine, build_machine
from pipeline.route.regions.endpoints import Endpoint, task_endpoints

Vary = Callable[..., Config]
WITHOUT_TILT = {"task.locked_axes": ["rx", "rz"]}


def _ready(config: Config) -> tuple[Config, Machine, tuple[Endpoint, Endpoint]]:
    machine = build_machine(config.machine)
    return config, machine, task_endpoints(config, machine)


def test_boxes_separate_what_the_theorem_separates(quick_config: Config, vary: Vary):
    """Without tilt no path has kappa <= 23.5, by boxes alone; the theorem needs none of them."""
    task = _ready(vary(quick_config, WITHOUT_TILT))
    found = bound_paths(*task, kappa=23.5, most_boxes=200_000)
    assert found.kappa == 23.5
    assert found.attempts[0].verdict is Verdict.NONE
    assert found.flood is not None
    assert not bound_paths(*task).attempts


def test_a_cap_above_a_known_path_is_never_proven(quick_config: Config):
    """A path with kappa below 27.3 is known: no number of boxes excludes kappa <= 100."""
    found = bound_paths(*_ready(quick_config), kappa=100.0, most_boxes=5_000)
    assert found.kappa is None
    assert found.attempts[0].verdict is not Verdict.NONE


def test_less_than_the_ends_have_is_trivial(quick_config: Config):
    """Every path has the kappa of its ends: a smaller K needs no boxes."""
    found = bound_paths(*_ready(quick_config), kappa=20.0, most_boxes=10_000)
    assert found.kappa == 20.0
    assert not found.attempts


def test_k_climbs_as_long_as_boxes_last(quick_config: Config, vary: Vary):
    """Without a K the floods begin a little above the ends, and end when there are no boxes left."""
    points = {"machine.links.l2b.platform_point_m": [0.09, 0.4501, -0.07], **WITHOUT_TILT}
    found = bound_paths(*_ready(vary(quick_config, points)), most_boxes=3_000)
    assert found.attempts[0].kappa == pytest.approx(1.02 * found.ends_kappa)
    assert found.least_kappa == max(found.ends_kappa, found.kappa or 0.0)
    assert found.attempts[-1].verdict is Verdict.LATE
    assert found.attempts[-1].boxes <= 3_000


def test_machines_without_a_chart_are_refused(quick_config: Config, vary: Vary):
    """An off-axis triangle is no reason for a guess."""
    changes: dict[str, Any] = {
        "machine.links.l3a.platform_point_m": [0.01, 0.1, 0.0],
        "machine.links.l3b.platform_point_m": [0.01, 0.38, 0.0],
    }
    with pytest.raises(NoSolutionError, match="y axis"):
        bound_paths(*_ready(vary(quick_config, changes)), kappa=25.0)
    assert bound_paths(*_ready(vary(quick_config, {**changes, **WITHOUT_TILT}))).theorem.no_path
    off_x = vary(quick_config, {"machine.rails.2.slopes": (0.0001, 0.0)})
    with pytest.raises(NoSolutionError, match="rails are not parallel"):
        bound_paths(*_ready(off_x), kappa=25.0)


def test_every_path_has_the_kappa_of_its_ends(quick_config: Config, vary: Vary):
    """What is known of all paths is at least that, also of a machine without a chart."""
    changes = {"machine.links.l3c.length_m": 1.26}
    found = bound_all_paths(*_ready(vary(quick_config, changes)), 10_000)
    assert not found.attempts
    assert found.least_kappa == found.ends_kappa


@pytest.mark.parametrize(("locked", "kappa"), [(["rx"], 37.2), (["rz"], 43.4), ([], 27.3)])
def test_bounds_never_exceed_known_paths(quick_config: Config, vary: Vary, locked: list[str], kappa: float):
    """Certified paths are known whose kappa is a little less: no boxes may separate their ends."""
    found = bound_paths(*_ready(vary(quick_config, {"task.locked_axes": locked})), kappa, 5_000)
    assert found.kappa is None
