"""Regions of grid and gates shared between runs."""

from dataclasses import fields

import numpy as np
import pytest

from pipeline.artifacts import region_cache
from pipeline.machine import build_machine
from pipeline.route import build_regions, grid_regions
from pipeline.stage import Stage


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


def test_with_a_known_grid_the_table_is_the_same(small_piece):
    """Computed in one go, or put together from a cached grid."""
    config, machine = small_piece
    one = build_regions(config, machine, grid=grid_regions(config, machine))
    other = build_regions(config, machine)
    for field in fields(one):
        a, b = getattr(one, field.name), getattr(other, field.name)
        assert a.dtype == b.dtype
        np.testing.assert_array_equal(a, b)


@pytest.fixture
def small_piece(quick_config, change):
    """Cut a small piece out of quick.yaml."""
    config = change(quick_config, route__grid__y_m__min=0.3, route__grid__y_m__max=0.4, task__tilt_max_deg=0)
    return config, build_machine(config.machine)
