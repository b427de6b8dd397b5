"""Regions of grid and gates kept beside the run folders, for all runs they are good for."""

import os
from dataclasses import fields
from pathlib import Path

import numpy as np
import pytest

from pipeline.artifacts import region_cache
from pipeline.artifacts.region_cache import KEPT, keep_grid, load_grid
from pipeline.machine import build_machine
from pipeline.route import build_regions, grid_regions
from pipeline.run import run_pipeline
from pipeline.run.fingerprint import config_part, grid_fingerprint
from pipeline.stage import Stage


@pytest.fixture(scope="module")
def table(make, quick_config):
    """Make a table of a few regions."""
    return make["regions"](build_machine(quick_config.machine), 4)


def _assert_same(one, other):
    for field in fields(one):
        a, b = getattr(one, field.name), getattr(other, field.name)
        assert a.dtype == b.dtype
        np.testing.assert_array_equal(a, b)


def _kept(runs: Path) -> list[str]:
    return sorted(path.name for path in (runs / region_cache.FOLDER).iterdir())


def test_what_is_kept_comes_back_exactly(tmp_path, table):
    """Every column, bit for bit; another key has nothing."""
    keep_grid(tmp_path, "a", table)
    _assert_same(load_grid(tmp_path, "a"), table)
    assert load_grid(tmp_path, "b") is None
    assert _kept(tmp_path) == ["a.npz"]


@pytest.mark.parametrize("damage", [b"", b"PK\x03\x04 and no more", "cut", "flipped", "another"])
def test_a_damaged_file_is_as_good_as_none(tmp_path, table, damage):
    """Empty, cut short, changed in one bit, or an archive of something else: the table is computed again."""
    keep_grid(tmp_path, "a", table)
    path = tmp_path / region_cache.FOLDER / "a.npz"
    content = bytearray(path.read_bytes())
    if damage == "cut":
        content = content[: len(content) // 2]
    elif damage == "flipped":
        content[content.find(np.float64(table.kappa[1]).tobytes())] ^= 1
    elif damage == "another":
        with path.open("wb") as file:
            np.savez(file, kappa=table.kappa)
        content = path.read_bytes()
    else:
        content = damage
    path.write_bytes(content)
    assert load_grid(tmp_path, "a") is None
    keep_grid(tmp_path, "a", table)
    _assert_same(load_grid(tmp_path, "a"), table)


def test_the_tables_used_last_stay(tmp_path, table):
    """What was read counts as used; leftovers of killed processes grow old like tables do."""
    for age in range(KEPT):
        keep_grid(tmp_path, f"{age}", table)
        os.utime(tmp_path / region_cache.FOLDER / f"{age}.npz", (1000 + age, 1000 + age))
    leftover = tmp_path / region_cache.FOLDER / ".x.npz.1.part"
    leftover.write_bytes(b"half")
    os.utime(leftover, (1, 1))
    assert load_grid(tmp_path, "0") is not None
    keep_grid(tmp_path, "new", table)
    assert _kept(tmp_path) == sorted(["new.npz", "0.npz", *(f"{age}.npz" for age in range(2, KEPT))])


def test_a_run_goes_on_where_nothing_can_be_kept(tmp_path, table):
    """A file in the place of the folder: nothing is kept, and nothing raised."""
    (tmp_path / region_cache.FOLDER).write_text("in the way")
    keep_grid(tmp_path, "a", table)
    assert load_grid(tmp_path, "a") is None
    assert (tmp_path / region_cache.FOLDER).read_text() == "in the way"


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
def test_the_key_changes_with_what_the_grid_depends_on_alone(fast_config, change, changes, same):
    """Start, goal, budgets, limits and names are none of it."""
    assert (grid_fingerprint(change(fast_config, **changes)) == grid_fingerprint(fast_config)) is same


def test_margins_count_for_the_table_only_where_there_are_boxes(fast_config, change):
    """They are counted in grid steps and steps along X."""
    for avoid, counts in (([], False), ([{"y_m": [5.0, 6.0]}], True)):
        base = change(fast_config, task__avoid=avoid)
        for key, value in (("route__avoid_margin", 1.0), ("route__x_step_m", 0.2)):
            other = change(base, **{key: value})
            same = config_part(other, Stage.REGIONS) == config_part(base, Stage.REGIONS)
            assert same is not counts


def test_runs_share_the_grid_until_told_to_compute_it_again(fast_config, change, stages, tmp_path):
    """Another name and start take it over, and say so; --force and another grid do not; damage is mended."""
    seen: list[str] = []

    class Listening:
        def begin(self, stage):
            return lambda message, fraction=None: seen.append(message)

        def end(self, stage, outcome, seconds):
            pass

    def run(name, config, **options):
        seen.clear()
        run_pipeline(config, tmp_path / name, last=Stage.REGIONS, reporter=Listening(), **options)
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
    """Computed at once, or put together from what was kept."""
    config, machine = small_piece
    _assert_same(build_regions(config, machine, grid=grid_regions(config, machine)), build_regions(config, machine))


@pytest.fixture
def small_piece(quick_config, change):
    """Cut a small piece out of quick.yaml."""
    config = change(quick_config, route__grid__y_m__min=0.3, route__grid__y_m__max=0.4, task__tilt_max_deg=0)
    return config, build_machine(config.machine)
