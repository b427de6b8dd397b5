"""Start and goal held against the grid."""

import re

import numpy as np
import pytest

from pipeline.config import Config
from pipeline.config.file import load_config
from pipeline.machine import build_machine
from pipeline.route import build_regions
from pipeline.route.diagnosis.endpoints import end_remarks
from pipeline.route.moves.candidates import Moves, find_moves
from tests.conftest import CONFIGS


@pytest.fixture(scope="module")
def config(vary) -> Config:
    """Take tiny.yaml with a tilt grid of 10 degrees."""
    tilts = {"route.grid.rx_step_deg": 10, "route.grid.rz_step_deg": 10, "task.tilt_max_deg": 10}
    return vary(load_config(CONFIGS / "tiny.yaml"), tilts)


def remarks(config: Config, cut_off: bool = False) -> list[str]:
    """Compute regions and moves, none of them where the ends are to be cut off, and ask for remarks."""
    machine = build_machine(config.machine)
    regions = build_regions(config, machine)
    none = np.empty(0, dtype=np.int64)
    moves = Moves(none, none) if cut_off else find_moves(config, machine, regions)
    return end_remarks(config, machine, regions, moves)


def test_nothing_to_remark(config: Config) -> None:
    """A task with moves at both ends and tilts on the grid is fine."""
    assert remarks(config) == []


def test_tilt_grid_of_zero_alone(config: Config, vary) -> None:
    """A tilt limit below a grid step leaves no tilt at all: said per axis, unless it is locked anyway."""
    both = remarks(vary(config, {"task.tilt_max_deg": 5}))
    assert both == [
        "the grid of rx and rz has 0 degrees alone: tilts are multiples of route.grid.rx_step_deg (10) and "
        "route.grid.rz_step_deg (10), and task.tilt_max_deg is 5"
    ]
    (one,) = remarks(vary(config, {"task.tilt_max_deg": 5, "route.grid.rz_step_deg": 5}))
    assert one.startswith("the grid of rx has 0 degrees alone")
    assert remarks(vary(config, {"task.locked_axes": ["rx", "rz"]})) == [
        "task.locked_axes holds both tilts: the platform cannot tilt at all"
    ]


@pytest.mark.parametrize(
    ("axis", "limits", "side", "wanted"),
    [("y", (0.7, 0.9), "min", "0.5 or less"), ("z", (0.5, 0.5), "max", "0.7 or more")],
)
def test_off_the_grid(config: Config, vary, axis: str, limits: tuple[float, float], side: str, wanted: str) -> None:
    """An end farther than a step from the grid is named with its axis and the range to choose, which then suffices."""
    grid = {"min": limits[0], "max": limits[1], "step": 0.2}
    found = remarks(vary(config, {f"route.grid.{axis}_m": grid}))
    assert len(found) == 2
    for name, remark in zip(("start", "goal"), found, strict=True):
        assert remark.startswith(f"task.{name}.{axis}_m is ")
        assert remark.endswith(f"let route.grid.{axis}_m.{side} be {wanted}")
    mended = grid | {side: float(wanted.split()[0])}
    assert not any("off the grid" in remark for remark in remarks(vary(config, {f"route.grid.{axis}_m": mended})))


def test_isolated(config: Config, vary) -> None:
    """Why each neighbour is refused, counted once each."""
    tight = vary(config, {"route.kappa_max": 24, "machine.clearance.link_link_m": 0.08, "task.tilt_max_deg": 10})
    for name, remark in zip(("start", "goal"), remarks(tight, cut_off=True), strict=True):
        assert remark.startswith(f"no move joins the {name} to anything: of the ")
        total = int(re.findall(r"of the (\d+) grid points", remark)[0])
        counts = [int(count) for count in re.findall(r"(?:; |[LR]{3}, )(\d+) ", remark)]
        assert sum(counts) == total == 81
        assert "kappa above route.kappa_max (24)" in remark
        assert "are regions, but" in remark
