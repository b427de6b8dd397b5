"""What stage one takes up is what was counted."""

import tracemalloc
from typing import Any

from pipeline.machine import build_machine
from pipeline.route import build_regions, plan_route
from pipeline.route.regions.size import expected_size


def test_stage_one_stays_within_what_is_allowed(quick_config: Any, vary: Any) -> None:
    """From the first array to the route, for a limit hardly above what is counted; and the count is not far above."""
    counted = expected_size(quick_config, build_machine(quick_config.machine)).memory_gb
    config = vary(quick_config, {"route.memory_gb": 1.05 * counted, "route.objective": "sum"})
    machine = build_machine(config.machine)
    tracemalloc.start()
    plan_route(config, machine, build_regions(config, machine))
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert 0.4 * counted < peak / 1e9 < 1.05 * counted
