"""Paths as files."""

import io
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.interpolate import BSpline

from pipeline.artifacts.npz import npz_bytes
from pipeline.artifacts.results.path import load_path, load_refinement, pack_refinement, path_files, save_path
from pipeline.errors import UsageError
from pipeline.export import read_csv
from pipeline.machine import Machine
from pipeline.refine.measure import sample_path
from pipeline.refine.result import MOST_DEGREE
from tests.artifacts.saved import SavedRun, put

Make = dict[str, Callable[..., Any]]


def test_refinement(tmp_path: Path, machine: Machine, make: Make) -> None:
    """Both paths come back: the same positions, derivatives and poses, exactly."""
    refinement = make["refinement"](machine)
    s = np.linspace(0.0, 1.0, 37)
    put(tmp_path, path_files(refinement, sample_path(refinement.path, s)))
    loaded = load_refinement(SavedRun(tmp_path, machine))
    for name in ("status", "iterations", "rounds", "nodes", "surrogate_integral"):
        assert getattr(loaded, name) == getattr(refinement, name)
    for ours, theirs in ((loaded.path, refinement.path), (loaded.coarse, refinement.coarse)):
        assert np.array_equal(ours.q(s), theirs.q(s))
        assert np.array_equal(ours.q(s, 1), theirs.q(s, 1))
        assert np.array_equal(ours.pose(s), theirs.pose(s))


def test_the_duration_of_a_timed_path_and_waits_of_a_route_come_back(
    tmp_path: Path, machine: Machine, make: Make
) -> None:
    """A path over time keeps its duration; two steps of a coarse path may be at one place."""
    refinement = make["refinement"](machine)
    coarse = refinement.coarse
    again = replace(
        coarse,
        node_s=np.sort(np.append(coarse.node_s, 0.0)),
        node_pose=coarse.node_pose[[0, *range(len(coarse.node_s))]],
    )
    refinement = replace(refinement, path=replace(refinement.path, motion_s=4.25), coarse=again)
    put(tmp_path, path_files(refinement, sample_path(refinement.path, np.linspace(0.0, 1.0, 5))))
    loaded = load_refinement(SavedRun(tmp_path, machine))
    assert loaded.path.motion_s == 4.25
    assert loaded.coarse.motion_s is None
    np.testing.assert_array_equal(loaded.coarse.node_s, again.node_s)


def test_a_path_of_its_own(tmp_path: Path, machine: Machine, make: Make) -> None:
    """What is saved is loaded, and so is the refined path of a run."""
    refinement = make["refinement"](machine)
    save_path(tmp_path / "one.npz", refinement.path)
    s = np.linspace(0.0, 1.0, 21)
    (tmp_path / "run.npz").write_bytes(npz_bytes(pack_refinement(refinement)))
    for name in ("one.npz", "run.npz"):
        loaded = load_path(tmp_path / name, machine)
        for order in range(4):
            np.testing.assert_array_equal(loaded.q(s, order), refinement.path.q(s, order))
        np.testing.assert_array_equal(loaded.pose(s), refinement.path.pose(s))
    (tmp_path / "one.npz").write_bytes(b"nonsense")
    with pytest.raises(UsageError, match=r"one\.npz"):
        load_path(tmp_path / "one.npz", machine)


@pytest.mark.parametrize("degree", [MOST_DEGREE, MOST_DEGREE + 1])
def test_every_degree_that_a_path_may_have_is_loaded(tmp_path: Path, machine: Machine, degree: int) -> None:
    """The limit is the path's own; beyond it the file is named with the degree and the limit."""
    start, goal = np.full(6, 0.1), np.full(6, 0.2)
    spline = BSpline(np.repeat([0.0, 1.0], degree + 1), np.ones((degree + 1, 5)), degree)
    arrays = {"degree": degree, "knots": spline.t, "coefficients": spline.c, "node_s": np.array([0.0, 1.0])}
    (tmp_path / "path.npz").write_bytes(npz_bytes({**arrays, "node_pose": np.stack([start, goal])}))
    if degree <= MOST_DEGREE:
        assert load_path(tmp_path / "path.npz", machine).spline.k == degree
        return
    with pytest.raises(UsageError, match=rf"path\.npz .*degree of the path: .* at most {MOST_DEGREE}, not {degree}"):
        load_path(tmp_path / "path.npz", machine)


def test_path_files_follow_the_contract(machine: Machine, make: Make) -> None:
    """The splines can be rebuilt from degree, knots and coefficients; the table has the contract's columns."""
    refinement = make["refinement"](machine)
    s = np.linspace(0.0, 1.0, 11)
    files = path_files(refinement, sample_path(refinement.path, s))
    arrays = np.load(io.BytesIO(files["path.npz"]))
    spline = BSpline(arrays["knots"], arrays["coefficients"], int(arrays["degree"]))
    assert arrays["coefficients"].shape[1] == 5
    columns = read_csv(files["path.csv"].decode())
    assert list(columns)[:8] == ["s", "x_m", "y_m", "z_m", "rx_rad", "ry_rad", "rz_rad", "kappa"]
    q = np.column_stack([columns[f"q{k}_m"] for k in range(1, 6)])
    np.testing.assert_allclose(q, spline(s), atol=1e-12)
