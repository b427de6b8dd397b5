"""Links that pass through thin bodies within a step: the filter, and what following such moves finds."""

import numpy as np
import pytest

from pipeline.config import Config
from pipeline.machine import Machine, build_machine
from pipeline.machine.bodies.distances import body_distances
from pipeline.route.metric import step_sizes
from pipeline.route.moves.body_passing import body_codes
from pipeline.route.moves.candidates import MoveSearch, find_moves
from pipeline.route.moves.check import check_moves
from pipeline.route.regions.build import build_regions
from pipeline.route.regions.table import RegionTable

BAR = {"capsule": {"from_m": [0.0, 0.25, 0.05], "to_m": [0.0, 0.25, 0.25], "radius_m": 0.002}}
"""A thin bar on the platform that links 2a and 2b sweep across."""


@pytest.fixture(scope="module")
def barred(quick_config: Config, vary) -> Config:
    """Take the machine of axes with the bar on its platform, and small clearances: links jump across it."""
    bar = {"name": "bar", "attached_to": "platform", **BAR}
    values = {"machine.bodies": [bar], "machine.clearance.bodies_m": 0.001, "machine.clearance.link_link_m": 0.0}
    return vary(quick_config, {**values, "route.grid.y_m.max": 0.6, "route.grid.y_m.min": 0.0})


@pytest.fixture(scope="module")
def table(barred: Config) -> RegionTable:
    """Find the regions."""
    return build_regions(barred, build_machine(barred.machine))


def test_machines_without_bodies_have_no_codes(machine: Machine, table: RegionTable) -> None:
    """Not one word more per region."""
    assert body_codes(machine, table, 16).shape == (0, len(table))


def test_codes_are_signs_of_distances(barred: Config, table: RegionTable) -> None:
    """A region has one sign at most of each pair, and both occur."""
    codes = body_codes(build_machine(barred.machine), table, 16)
    assert codes.shape == (1, len(table))
    positive, negative = codes[0] & 0xFFFF, codes[0] >> 16
    assert not (positive & negative).any()
    assert (positive > 0).any()
    assert (negative > 0).any()


def test_moves_on_which_a_link_passes_through_a_bar_are_left_out(barred: Config, table: RegionTable) -> None:
    """The bar is thinner than a step: both ends are clear. Followed, most of these moves meet it."""
    machine, steps = build_machine(barred.machine), step_sizes(barred.route)
    codes = body_codes(machine, table, 16)
    free = MoveSearch.of(table, steps, np.zeros(len(table), dtype=np.int64), steps[0]).collect(lambda *_: None)
    i, j = free.source, free.target
    crossing = ((codes[0][i] & (codes[0][j] >> 16)) | ((codes[0][i] >> 16) & codes[0][j])) & 0xFFFF
    same = (table.det_sign[i] == table.det_sign[j]) & (j < table.start) & (i < table.start)
    rows = np.flatnonzero((crossing > 0) & same)
    assert len(rows) > 100
    moves = find_moves(barred, machine, table)
    pairs = set(zip(moves.source.tolist(), moves.target.tolist(), strict=True))
    assert not pairs & set(zip(i[rows].tolist(), j[rows].tolist(), strict=True))
    picked = rows[:: len(rows) // 60]
    ends = np.column_stack([i[picked], j[picked]])
    assert body_distances(machine.bodies, table.samples(machine).take(np.unique(ends))).min() >= 0.001
    checks = check_moves(barred, machine, table.pose[ends], table.q_m[ends])
    assert (~checks.good).mean() > 0.8
    assert "bodies come too close" in map(str, checks.rejections)
