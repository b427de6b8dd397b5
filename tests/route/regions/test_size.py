"""Sizes that are counted before anything is allocated."""

import math
import tracemalloc
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pipeline.config import Config
from pipeline.errors import ConfigError, NoSolutionError, UnfitConfigError
from pipeline.route.memory import POINT_BYTES
from pipeline.route.regions.build import grid_regions
from pipeline.route.regions.grid import grid_points, grid_shape, points_at
from pipeline.route.regions.size import expected_size, require_grid_fits, require_table_fits
from pipeline.route.regions.task_rows import add_task_rows


def test_the_estimate_is_close(quick: Any) -> None:
    """Regions with gates and moves within a quarter, from a sample of the grid."""
    size = expected_size(quick.config, quick.machine)
    assert size.points == math.prod(grid_shape(quick.config))
    assert size.regions == pytest.approx(len(quick.regions), rel=0.15)
    assert size.moves == pytest.approx(len(quick.moves), rel=0.25)


def test_points_by_number_are_those_of_the_list(small_config: Config) -> None:
    """A few points can be had without all others."""
    points = grid_points(small_config)
    numbers = [0, 7, len(points) - 1]
    assert points_at(small_config, numbers).tolist() == points[numbers].tolist()


@given(step=st.floats(5e-324, 20.0), tilt=st.floats(5e-324, 85.0))
def test_every_grid_can_be_counted(quick_config: Config, vary: Any, step: float, tilt: float) -> None:
    """No step overflows; a grid whose points fit is one that can be listed, and others name the longest axis."""
    config = vary(quick_config, {"route.grid.y_m.step": step, "route.grid.rx_step_deg": tilt, "route.memory_gb": 0.01})
    count = math.prod(grid_shape(config))
    if count * POINT_BYTES <= 0.01e9:
        require_grid_fits(config)
        assert len(grid_points(config)) == count
        return
    with pytest.raises(ConfigError, match=r"route\.grid\.\w+.* route\.memory_gb allows 0\.01"):
        require_grid_fits(config)


@pytest.mark.parametrize("key", ["y_m.step", "z_m.step", "rx_step_deg", "rz_step_deg"])
def test_the_axis_with_most_values_is_named(quick_config: Config, vary: Any, key: str) -> None:
    """With its step, the points in all, what they take and what is allowed."""
    with pytest.raises(ConfigError, match=rf"route\.grid\.{key}: is 1e-08, which makes [\d,]{{9,}} values"):
        require_grid_fits(vary(quick_config, {f"route.grid.{key}": 1e-8}))


@pytest.mark.parametrize(("step", "values"), [(5e-324, "at least 1,000,000,000,001"), (1e-8, "160,000,001")])
def test_what_is_not_counted_to_the_end_is_a_bound(quick_config: Config, vary: Any, step: float, values: str) -> None:
    """The step is shown as it was written; no count that was given up passes for an exact one."""
    with pytest.raises(ConfigError, match=rf"is {step!r}, which makes {values} values"):
        require_grid_fits(vary(quick_config, {"route.grid.y_m.step": step}))


def test_a_table_that_does_not_fit_is_refused_at_once(quick: Any, vary: Any) -> None:
    """Nothing as large as the table is allocated; the message has the numbers and a value that would do."""
    config = vary(quick.config, {"route.memory_gb": 0.03})
    tracemalloc.start()
    with pytest.raises(UnfitConfigError, match=r"12,495 points.* regions and .* moves.*allows 0\.03") as caught:
        require_table_fits(config, quick.machine)
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert caught.value.exit_code == 2
    assert peak < 40e6
    require_table_fits(vary(quick.config, {"route.memory_gb": 0.1}), quick.machine)


def test_visits_and_boxes_count(quick: Any, vary: Any) -> None:
    """A hundred visits anywhere repeat all regions, and their moves a hundred times a hundred."""
    visits = [{"box": {"x_m": [0.0, 2.0]}}] * 100
    with pytest.raises(UnfitConfigError, match=r"leave out some of task\.visit"):
        require_table_fits(vary(quick.config, {"task.visit": visits}), quick.machine)
    slabs = [{"x_m": [1.2 + 0.02 * k, 1.21 + 0.02 * k]} for k in range(20)]
    cut = expected_size(vary(quick.config, {"task.avoid": slabs, "route.avoid_margin": 0.0}), quick.machine)
    assert cut.regions > 2.0 * expected_size(quick.config, quick.machine).regions


def test_what_was_not_foreseen_ends_while_it_grows(quick: Any, vary: Any) -> None:
    """Regions are counted as they are found, and rows as the task repeats them."""
    with pytest.raises(NoSolutionError, match=r"regions and more would take up .* route\.memory_gb allows 0\.003"):
        grid_regions(vary(quick.config, {"route.memory_gb": 0.003}), quick.machine)
    visits = {"task.visit": [{"box": {"x_m": [0.0, 2.0]}}] * 5, "route.memory_gb": 0.02}
    with pytest.raises(NoSolutionError, match=r"5 entries of task\.visit, would take up"):
        add_task_rows(vary(quick.config, visits), quick.machine, quick.regions.take(slice(0, -2)))
