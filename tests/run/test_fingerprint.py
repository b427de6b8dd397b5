"""Fingerprints: what they depend on."""

from collections.abc import Callable
from typing import Any

import pytest

from pipeline.config import Config
from pipeline.run.fingerprint import fingerprint, grid_fingerprint
from pipeline.run.stage_specs import SPECS
from pipeline.stage import Stage

Change = Callable[..., Config]


def test_fingerprint_depends_on_results(fast_config: Config) -> None:
    """Another result of an earlier stage gives another fingerprint."""
    one, other = ({Stage.REGIONS: name} for name in "ab")
    assert fingerprint(SPECS, Stage.ROUTE, fast_config, one) == fingerprint(SPECS, Stage.ROUTE, fast_config, one)
    assert fingerprint(SPECS, Stage.ROUTE, fast_config, one) != fingerprint(SPECS, Stage.ROUTE, fast_config, other)


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
