"""Obstacles cut the windows of regions, and routes keep clear of them."""

import numpy as np
import pytest

from pipeline.config import Config
from pipeline.errors import ConfigError
from pipeline.limits.bodies.obstacle_distance import obstacles_of
from pipeline.machine import Machine, build_machine
from pipeline.machine.bodies.distances import body_distances
from pipeline.machine.samples import PoseSamples
from pipeline.route.moves.candidates import find_moves
from pipeline.route.moves.check import check_moves, check_pairs
from pipeline.route.moves.obstacle_passing import obstacle_codes, obstacles_hit
from pipeline.route.regions.build import build_regions, grid_regions
from pipeline.route.regions.endpoints import task_endpoints
from pipeline.route.regions.obstacles import cut_at_obstacles
from pipeline.route.regions.table import RegionTable

POST = {"name": "post", "capsule": {"from_m": [1.3, 0.7, 0.0], "to_m": [1.3, 0.7, 1.4], "radius_m": 0.02}}


@pytest.fixture(scope="module")
def blocked(small_config: Config, vary) -> Config:
    """Put a post beside the machine of axes, on a small grid."""
    return vary(small_config, {"task.obstacles": [POST]})


@pytest.fixture(scope="module")
def tables(blocked: Config) -> tuple[Machine, RegionTable, RegionTable]:
    """Find the regions of the grid, and what the post leaves of them."""
    machine = build_machine(blocked.machine)
    grid = grid_regions(blocked, machine)
    return machine, grid, cut_at_obstacles(blocked, machine, grid)


def distances_at(config: Config, machine: Machine, table: RegionTable, x: np.ndarray) -> np.ndarray:
    """Measure the distances of all pairs of regions at x (n,)."""
    pose, q = table.pose, table.q_m.copy()
    q[:, :3] += (x - pose[:, 0])[:, None]
    pose[:, 0] = x
    pairs = obstacles_of(config)
    assert pairs is not None
    return body_distances(pairs, PoseSamples(machine, pose, q))


def test_windows_are_clear_all_along(blocked: Config, tables) -> None:
    """At both ends and at places between them; nothing is lost of regions that do not meet the post."""
    machine, grid, cut = tables
    for share in (0.0, 0.3, 0.6, 1.0):
        x = cut.x_window_m @ [1.0 - share, share]
        assert distances_at(blocked, machine, cut, x).min() >= 0.005
    length = [np.ptp(table.x_window_m, axis=1).sum() for table in (grid, cut)]
    assert 0.5 * length[0] < length[1] < 0.99 * length[0]


def test_without_obstacles_nothing_is_cut(small_config: Config, tables) -> None:
    """The table stays as it is, and has no codes."""
    machine, grid, _ = tables
    assert cut_at_obstacles(small_config, machine, grid) is grid
    assert obstacle_codes(small_config, machine, grid, 16).shape == (0, len(grid))
    assert not obstacles_hit(small_config, machine, grid, np.zeros((3, 2), dtype=np.int64)).any()


def test_admitted_moves_are_clear_for_every_x(blocked: Config, tables) -> None:
    """Wherever in their windows they are made, as far as a step goes; and most of them are admitted."""
    machine = tables[0]
    table = build_regions(blocked, machine, grid=tables[1])
    moves = find_moves(blocked, machine, table)
    codes = obstacle_codes(blocked, machine, table, 16)[0]
    beside = np.flatnonzero((codes[moves.source] != 0) | (codes[moves.target] != 0))
    rng = np.random.default_rng(4)
    picked = rng.choice(beside, 150, replace=False)
    ends = np.column_stack([moves.source[picked], moves.target[picked]])
    good = check_pairs(blocked, machine, table, ends[:, 0], ends[:, 1]).good
    assert good.mean() > 0.5
    ends = ends[good]
    for _ in range(4):
        low, high = np.moveaxis(table.x_window_m[ends], -1, 0)
        x = low + rng.uniform(size=low.shape) * (high - low)
        x[:, 1] = np.clip(x[:, 1], x[:, 0] - 0.1, x[:, 0] + 0.1)
        x[:, 1] = np.clip(x[:, 1], low[:, 1], high[:, 1])
        near = np.abs(x[:, 1] - x[:, 0]) <= 0.1
        pose, q = table.pose[ends], table.q_m[ends]
        q[..., :3] += (x - pose[..., 0])[..., None]
        pose[..., 0] = x
        assert check_moves(blocked, machine, pose[near], q[near]).good.all()


def test_a_start_at_an_obstacle_is_refused(blocked: Config, vary) -> None:
    """With the pair."""
    start = blocked.task.start
    place = [start.x_m, start.y_m, start.z_m]
    config = vary(blocked, {"task.obstacles": [{"name": "ball", "hull": {"points_m": [place], "radius_m": 0.02}}]})
    with pytest.raises(ConfigError) as error:
        task_endpoints(config, build_machine(config.machine))
    assert "TCP and ball overlapping by 0.02" in error.value.issues[0].message
    assert error.value.issues[0].path == "task.start"
