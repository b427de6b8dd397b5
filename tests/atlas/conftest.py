"""A small machine task with stations, on and off the grid."""

from collections.abc import Callable

import numpy as np
import pytest

from pipeline.atlas import AtlasEntry, AtlasGraph, atlas_stations, build_graph, plan_pairs
from pipeline.atlas.plan import Pair
from pipeline.config import Config
from pipeline.machine import MODES, Machine, build_machine
from pipeline.route import RegionTable, grid_regions
from tests.route.conftest import *  # noqa: F403  # fixtures are found by their names here

Plan = Callable[..., tuple[AtlasGraph, dict[Pair, AtlasEntry]]]


@pytest.fixture(scope="session")
def small_grid(small_config: Config) -> RegionTable:
    """Compute the regions of grid and gates of `small_config`."""
    return grid_regions(small_config, build_machine(small_config.machine))


@pytest.fixture(scope="session")
def with_stations(small_config: Config, small_grid: RegionTable, vary) -> Callable[..., Config]:
    """Give a function that adds stations drawn from the regions to `small_config`, moved off the grid or not."""

    def add(
        seed: int, count: int = 3, changes: dict[str, object] | None = None, *, off_grid_m=0.0, apart_m=0.0
    ) -> Config:
        rng = np.random.default_rng(seed)
        inner = np.flatnonzero((small_grid.gates == 0) & (small_grid.kappa < 40.0) & (small_grid.det_sign > 0.0))
        rows = rng.choice(inner, count, replace=False)
        stations = []
        for k, row in enumerate(rows.tolist()):
            least, largest = small_grid.x_window_m[row]
            _, y, z, rx, rz = small_grid.controlled[row]
            y, z = np.array([y, z]) + rng.uniform(-off_grid_m, off_grid_m, 2)
            x = np.clip(0.8 + apart_m * k, least, largest)
            pose = {"x_m": float(x), "y_m": float(y), "z_m": float(z), "mode": MODES[small_grid.modes[row]]}
            pose |= {"rx_deg": float(np.rad2deg(rx).round(9)), "rz_deg": float(np.rad2deg(rz).round(9))}
            stations.append({"name": f"s{k}", "pose": pose})
        return vary(small_config, {"atlas.stations": stations, **(changes or {})})

    return add


@pytest.fixture(scope="session")
def plan_all(small_grid: RegionTable) -> Plan:
    """Give a function that plans all pairs of a configuration on the regions of `small_config`."""

    def plan(config: Config, machine: Machine | None = None, grid: RegionTable | None = None, **options: bool):
        machine = machine or build_machine(config.machine)
        stations = atlas_stations(config)
        graph = build_graph(config, machine, stations, small_grid if grid is None else grid)
        pairs = [(i, j) for i in range(len(stations)) for j in range(len(stations)) if i != j]
        entries: dict[Pair, AtlasEntry] = {}
        assert [entry.pair for entry in plan_pairs(graph, pairs, entries, **options)] == pairs
        return graph, entries

    return plan
