"""Joints that turn too little for a route, and how far they would have to turn."""

from collections.abc import Callable

import pytest

from pipeline.config import Config
from pipeline.config.file import load_config
from pipeline.errors import InfeasibleError
from pipeline.limits import relaxations
from pipeline.limits.joint_cone import ALL_CONES
from pipeline.machine import build_machine
from pipeline.route import Route, build_regions, plan_route
from pipeline.route.diagnosis.result import Verdict
from pipeline.route.diagnosis.search import explain_infeasibility
from tests.conftest import CONFIGS

CART = "machine.links.l3b.cart_cone.half_angle_deg"
PLATFORM = "machine.links.l2a.platform_cone.half_angle_deg"


def plan(config: Config) -> Route:
    """Plan with the regions of a configuration."""
    machine = build_machine(config.machine)
    return plan_route(config, machine, build_regions(config, machine))


def test_the_joint_that_bars_the_way_is_named(vary: Callable) -> None:
    """With the angle that opens a route: with a degree less there is none, and other joints do not matter."""
    tiny = load_config(CONFIGS / "tiny.yaml")
    cones = {
        "machine.links.l2a.platform_cone": {"axis": [0.0, 0.99, -0.14], "half_angle_deg": 120.0},
        "machine.links.l3b.cart_cone": {"axis": [0.0, 0.41, 0.91], "half_angle_deg": 45.5},
    }
    config = vary(tiny, cones)
    machine = build_machine(config.machine)
    with pytest.raises(InfeasibleError):
        plan(config)
    limits = [limit for limit in relaxations(config, machine) if "cone" in limit.key]
    report = explain_infeasibility(config, machine, build_regions(config, machine), limits=limits)
    findings = {finding.key: finding for finding in report.findings if "cone" in finding.key}
    assert list(findings) == [ALL_CONES, PLATFORM, CART]
    assert [findings[key].verdict for key in findings] == [Verdict.OPENS, Verdict.NEVER, Verdict.OPENS]
    assert findings[ALL_CONES].advice == f"remove {ALL_CONES}"
    wide_enough = findings[CART].value
    assert wide_enough is not None
    assert findings[CART].advice == f"set {CART} to {wide_enough:g}"
    assert "route exists" in findings[CART].sentence
    assert plan(vary(config, {CART: wide_enough})).objective > plan(tiny).objective
    with pytest.raises(InfeasibleError):
        plan(vary(config, {CART: findings[CART].refused}))
