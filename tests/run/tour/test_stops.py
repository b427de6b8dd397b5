"""Poses to drive to, from a table."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from pipeline.config import Config
from pipeline.errors import UsageError
from pipeline.run.tour import read_stops
from tests.run.tour.conftest import CONTROLLED, MODES_OF


def test_proposed_poses_are_read_back(cell: Config, poses_file: Path):
    """In their order, with the working modes that carts tell, and the reflectors that are to be filled in."""
    table = read_stops(poses_file, cell)
    assert [station.name for station in table.stations] == ["pose-1", "pose-2", "pose-3", "pose-4"]
    assert [station.pose.mode for station in table.stations] == MODES_OF
    read = [[getattr(one.pose, key) for key in ("x_m", "y_m", "z_m", "rx_deg", "rz_deg")] for one in table.stations]
    np.testing.assert_allclose(np.array(read)[:, :3], CONTROLLED[:, :3], atol=1e-8)
    np.testing.assert_allclose(np.array(read)[:, 3:], np.rad2deg(CONTROLLED[:, 3:]), atol=1e-5)
    assert table.blanks == ("x1_m", "y1_m", "z1_m", "x2_m", "y2_m", "z2_m")
    assert table.stations[2].key.endswith("first.csv, line 4")


def test_what_is_not_a_number_is_refused(cell: Config, changed_poses: Callable[[int, str, str], Path]):
    """With its place."""
    with pytest.raises(UsageError, match="line 3"):
        read_stops(changed_poses(2, "z_m", "high"), cell)
