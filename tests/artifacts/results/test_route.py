"""The route as files."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from pipeline.artifacts.npz import npz_bytes
from pipeline.artifacts.results.route import load_route, route_files
from pipeline.errors import UsageError
from pipeline.export import read_csv
from pipeline.machine import Machine
from pipeline.status import Status
from tests.artifacts.saved import SavedRun, put, same

Make = dict[str, Callable[..., Any]]


def test_route(tmp_path: Path, machine: Machine, make: Make) -> None:
    """The route comes back with everything about its search."""
    route = make["route"](machine)
    put(tmp_path, route_files(route))
    loaded = load_route(SavedRun(tmp_path, machine))
    assert same(loaded, route)
    assert loaded.search == route.search
    assert loaded.status is Status.OPTIMAL


def test_route_csv(tmp_path: Path, machine: Machine, make: Make) -> None:
    """The route's table has the columns of the contract and the route's values."""
    route = make["route"](machine)
    columns = read_csv(route_files(route)["route.csv"].decode())
    assert list(columns) == (
        ["step", "region", "mode", "x_m", "y_m", "z_m", "rx_rad", "ry_rad", "rz_rad", "kappa"]
        + [f"q{k}_m" for k in range(1, 6)]
        + ["gate"]
    )
    assert columns["mode"].tolist() == ["LLL", "LLL", "LLL", "LLR"]
    assert columns["region"].tolist() == route.region.tolist()
    np.testing.assert_allclose(columns["q5_m"], route.q_m[:, 4], atol=1e-12)


@pytest.mark.parametrize("damage", ["other", "short", "pickle"])
def test_unreadable_file_is_named(tmp_path: Path, machine: Machine, make: Make, damage: str) -> None:
    """A file of another format is refused with its name and what to do, not with a traceback."""
    if damage == "other":
        put(tmp_path, {"route.npz": npz_bytes({"region": np.arange(3)})})
    elif damage == "short":
        put(tmp_path, {"route.npz": route_files(make["route"](machine))["route.npz"][:500]})
    else:
        np.savez(tmp_path / "route.npz", region=np.array([object()], dtype=object))
    with pytest.raises(UsageError, match=r"route\.npz cannot be read"):
        load_route(SavedRun(tmp_path, machine))
