"""Regions of grid and gates shared between runs."""

from collections.abc import Callable
from typing import Any

import pytest

from pipeline.artifacts import region_cache
from pipeline.config import Config
from pipeline.run.makers.grid_cache import grid_fingerprint
from pipeline.stage import Stage

Change = Callable[..., Config]


@pytest.mark.parametrize(
    ("changes", "same"),
    [
        ({"name": "other", "task__start__x_m": 1.0, "task__goal__z_m": 0.8, "route__step_budget": 40}, True),
        ({"route__memory_gb": 2.0, "machine__limits__carts__velocity_mps": 0.1, "route__x_step_m": 0.2}, True),
        ({"task__avoid": [{"y_m": [5.0, 6.0]}], "route__avoid_margin": 1.0}, True),
        ({"task__tilt_max_deg": 25}, False),
        ({"task__locked_axes": ["rx"]}, False),
        ({"route__kappa_max": 99}, False),
        ({"route__grid__y_m__step": 0.2}, False),
        ({"machine__clearance__link_link_m": 0.04}, False),
        ({"machine__links__l1__length_m": 1.1}, False),
    ],
)
def test_the_key_changes_with_what_the_grid_depends_on_alone(
    fast_config: Config, change: Change, changes: dict[str, Any], same: bool
) -> None:
    """Start, goal, budgets, limits and names are none of it."""
    assert (grid_fingerprint(change(fast_config, **changes)) == grid_fingerprint(fast_config)) is same


def test_runs_share_the_grid_until_told_to_compute_it_again(fast_config, change, stages, tmp_path):
    """Another name and start take it over, and say so; --force and another grid do not; damage is mended."""
    stages.caches = True
    seen: list[str] = []

    class Listening:
        def begin(self, stage):
            return lambda message, fraction=None: seen.append(message)

        def end(self, stage, outcome, seconds):
            pass

    def run(name, config, **options):
        seen.clear()
        stages.run(config, tmp_path / name, Listening(), last=Stage.REGIONS, **options)
        return stages.grids, any("known from an earlier run" in message for message in seen)

    assert run("one", fast_config) == (1, False)
    other = change(fast_config, name="two", task__start__x_m=1.0)
    assert run("two", other) == (1, True)
    assert run("two", other, force=True) == (2, False)
    assert run("two", other, first=Stage.REGIONS) == (3, False)
    assert run("two", change(other, route__kappa_max=90)) == (4, False)
    for path in (tmp_path / region_cache.FOLDER).iterdir():
        path.write_bytes(b"damaged")
    assert run("three", fast_config) == (5, False)
    assert run("four", fast_config) == (5, True)
