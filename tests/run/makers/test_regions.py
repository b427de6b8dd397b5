"""The region table, from a grid that is known or computed."""

from dataclasses import fields

import numpy as np
import pytest

from pipeline.machine import build_machine
from pipeline.route import build_regions, grid_regions


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
