"""Driving a tour: its order, what is left out, and what takes its place."""

import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from pipeline.atlas.graph import AtlasGraph
from pipeline.atlas.tour import tour_cost, tour_order
from pipeline.config import Config
from pipeline.errors import NoSolutionError, UsageError
from pipeline.export.csv import read_csv
from pipeline.progress import Monitor
from pipeline.run.tour import Leg, TourOptions, make_tour, read_stops
from pipeline.run.tour.drive import Make, drive
from tests.run.fake_stages import FakeStages


def making(*impossible: int) -> Make:
    """Give a function that makes all legs but those to some stations."""

    def make(origin: int, target: int, monitor: Monitor) -> Leg:
        monitor.progress("made")
        if target in impossible:
            raise NoSolutionError("tour", "refine: not converged", "give it more nodes")
        return Leg(origin, target, Path(), {})

    return make


def test_all_poses_are_visited_in_a_short_order(graph: AtlasGraph):
    """Leg by leg in one chain from the start and back, which is told."""
    said: list[tuple[str, float | None]] = []
    tour = drive(graph, making(), None, {}, Monitor(lambda message, fraction=None: said.append((message, fraction))))
    stations = [0, *(leg.target for leg in tour.legs)]
    assert [leg.origin for leg in tour.legs] == stations[:-1]
    assert sorted(stations) == [0, 0, 1, 2, 3, 4]
    costs = graph.station_costs
    assert tour_cost(costs, stations) == tour_cost(costs, (0, *tour_order(costs, 0, range(1, 5), 0), 0))
    assert [message for message, _ in said] == [f"leg {k} of 5, made" for k in range(1, 6)]


def test_another_pose_takes_the_place_of_one_that_fails(graph: AtlasGraph):
    """Of those beyond the number wanted, in the order of the table; why is told, with the stage."""
    tour = drive(graph, making(2), 3, {})
    assert {leg.target for leg in tour.visits} == {1, 3, 4}
    assert list(tour.left_out) == ["pose-2"]
    assert "refine: not converged" in tour.left_out["pose-2"]
    assert tour.legs[-1].target == 0


def test_poses_that_nothing_joins_are_left_out(graph: AtlasGraph):
    """There and back: a pose that one could only go to is not visited either."""
    forward = graph.forward.copy()
    forward[1, -5] = np.inf
    tour = drive(replace(graph, forward=forward), making(), 3, {"pose-9": "it is out of reach"})
    assert set(tour.left_out) == {"pose-1", "pose-9"}
    assert {leg.target for leg in tour.visits} == {2, 3, 4}


def test_no_way_back_is_told(graph: AtlasGraph):
    """The legs there are kept."""
    tour = drive(graph, making(0), 1, {})
    assert [leg.target for leg in tour.legs] == [1]
    assert tour.no_return == "no way back from pose-1; refine: not converged"


def test_a_tour_is_one_motion_on_disk(cell: Config, changed_poses: Callable[[int, str, str], Path], tmp_path: Path):
    """Record, motion and table to be filled in agree; what is up to date is not made again; the unreachable is told."""
    stages, folder = FakeStages(), tmp_path / "t"
    table = read_stops(changed_poses(1, "z_m", "3.0"), cell)
    table = replace(table, stations=table.stations[:2])
    tour = make_tour(cell, table, folder, TourOptions(specs=stages.specs))
    assert "out of reach" in tour.left_out["pose-1"]
    data = json.loads((folder / "tour.json").read_text())
    assert data["poses"] == 1
    assert [leg["verdict"] for leg in data["legs"]] == ["certified"] * 2
    assert data["legs"][1]["begin_s"] == data["legs"][0]["end_s"]
    motion, poses = (read_csv((folder / name).read_text()) for name in ("tour.csv", "poses.csv"))
    assert motion["t_s"][-1] == pytest.approx(data["duration_s"])
    assert poses["to_s"].tolist() == pytest.approx([data["legs"][0]["end_s"]])
    assert poses["pose"].tolist() == ["pose-2"]
    assert poses["z2_m"].tolist() == [""]
    stages.taken()
    make_tour(cell, table, folder, TourOptions(leg_s=60.0, specs=stages.specs))
    assert stages.taken() == []


def test_there_is_no_tour_without_a_pose(cell: Config, changed_poses: Callable[[int, str, str], Path], tmp_path: Path):
    """The first reason is given."""
    table = read_stops(changed_poses(1, "z_m", "3.0"), cell)
    with pytest.raises(NoSolutionError, match="none of 1 poses can be reached; pose-1: it is out of reach"):
        make_tour(cell, replace(table, stations=table.stations[:1]), tmp_path / "t")


def test_other_folders_are_not_touched(cell: Config, poses_file: Path, tmp_path: Path):
    """One with other files is refused."""
    (tmp_path / "notes.txt").write_text("mine")
    with pytest.raises(UsageError, match="no tour"):
        make_tour(cell, read_stops(poses_file, cell), tmp_path)
    assert [file.name for file in tmp_path.iterdir()] == ["notes.txt"]
