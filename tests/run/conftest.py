"""Stages that take no time: the real result types, filled with a short path of the reference machine."""

import pathlib
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import pytest
from matplotlib.figure import Figure
from scipy.interpolate import make_interp_spline

from pipeline.certify import Bounds, Certificate, ProvenChain, Tolerance, path_sha256
from pipeline.certify.guess import point_box
from pipeline.config import Config
from pipeline.config.file import parse_config
from pipeline.inclusion.krawczyk import Box
from pipeline.inclusion.uncertainty import CERTAIN, of_everything, of_lengths
from pipeline.machine import Machine, inverse_kinematics
from pipeline.progress import QUIET, Monitor, Progress, silent
from pipeline.refine.result import Path, Refinement
from pipeline.retime.result import Trajectory
from pipeline.route.regions.build import RegionTable
from pipeline.route.result import Route, Search
from pipeline.status import Status

NODES = 21


@pytest.fixture(autouse=True)
def no_terminal(monkeypatch: pytest.MonkeyPatch) -> None:
    """Run every command without the settings of whoever runs the tests."""
    for name in ("FORCE_COLOR", "PY_COLORS", "GITHUB_ACTIONS", "NO_COLOR", "COLUMNS", "TTY_COMPATIBLE"):
        monkeypatch.delenv(name, raising=False)


def changed(config: Config, **changes: Any) -> Config:
    """Change keys of a configuration, named by paths with two underscores for a dot."""
    data = config.model_dump(mode="json")
    for path, value in changes.items():
        *sections, key = path.split("__")
        part = data
        for section in sections:
            part = part[section]
        part[key] = value
    return parse_config(data)


@pytest.fixture(scope="session")
def change() -> Callable[..., Config]:
    """Give tests `changed`."""
    return changed


@pytest.fixture(scope="session")
def fast_config(quick_config: Config) -> Config:
    """Take few check points, so that measuring costs nothing."""
    return changed(quick_config, refine__check_points=1_000)


def line_of_poses(machine: Machine, count: int) -> tuple[np.ndarray, np.ndarray]:
    """Poses (n, 6) and actuators (n, 5) on a short line in working mode LLL."""
    controlled = np.linspace([1.02, 0.3, 0.9, 0.0, 0.0], [1.05, 0.33, 0.88, 0.05, -0.02], count)
    solution = inverse_kinematics(machine, controlled, np.zeros(count, dtype=int))
    return solution.pose, solution.q_m


def make_regions(machine: Machine, count: int = 5) -> RegionTable:
    """Make a table of a few regions with a column of each kind of value."""
    pose, q = line_of_poses(machine, count)
    return RegionTable(
        controlled=pose[:, [0, 1, 2, 3, 5]],
        ry_rad=pose[:, 4],
        modes=np.arange(count),
        gates=np.arange(count) % 4,
        q_m=q,
        kappa=np.geomspace(20.0, 30.0, count),
        det_sign=np.ones(count),
        link_distance_m=np.linspace(0.03, 0.1, count),
        x_window_m=np.stack([np.linspace(0.1, 0.2, count), np.linspace(1.0, 1.1, count)], axis=1),
        visits=np.arange(count) % 2,
    )


def make_route(machine: Machine, objective: float = 100.0) -> Route:
    """Make a route of four steps with one change of working mode."""
    pose, q = line_of_poses(machine, 4)
    return Route(
        region=np.array([3, 0, 1, 4]),
        modes=np.array([0, 0, 0, 1]),
        gates=np.array([0, 0, 3, 0]),
        visits=np.array([0, 1, 0, 0]),
        pose=pose,
        q_m=q,
        kappa=np.array([25.0, 1.0 / 0.03, 30.0, 24.0]),
        objective=objective,
        status=Status.OPTIMAL,
        search=Search("HiGHS 1", objective, 0.0, 99.0, 105.0, 5, 40, 12, 2, 7, 3),
    )


def make_path(machine: Machine, degree: int) -> Path:
    """Interpolate the line of poses in actuator space."""
    pose, q = line_of_poses(machine, NODES)
    s = np.linspace(0.0, 1.0, NODES)
    return Path(machine, make_interp_spline(s, q, k=degree), s, pose)


def make_refinement(machine: Machine) -> Refinement:
    """Make a refined path and a coarse one."""
    return Refinement(
        path=make_path(machine, 5),
        coarse=make_path(machine, 1),
        status=Status.CONVERGED,
        iterations=17,
        rounds=1,
        meshes=2,
        mesh_change=0.001,
        nodes=100,
        surrogate_integral=71.5,
    )


def make_certificate(path: Path) -> Certificate:
    """Make a certificate of one box, and of two more for machines that are a little wrong."""
    pose = path.pose(np.array([0.0, 0.5, 1.0]))
    box = Box(0.0, 1.0, np.vstack([pose[1], pose[2] - pose[0], np.zeros((2, 6))]), np.full(6, 0.1))
    joints = (point_box(0.0, pose[0]), point_box(1.0, pose[2]))
    proofs = [ProvenChain(given, (box,), joints) for given in (CERTAIN, of_lengths(1e-4), of_everything(1e-4))]
    bounds = Bounds(
        kappa=31.0,
        kappa_s=0.5,
        det_sign=1,
        pairs=("links 1 and 2a",),
        distances_m=np.array([0.1]),
        actuators_m=np.array([[0.5, 1.5]] * 5),
        tilt_rad=np.array([0.1, 0.05]),
        start_miss=1e-11,
        goal_miss=2e-11,
    )
    return Certificate(
        path_sha256=path_sha256(path),
        premises_sha256="0" * 64,
        precision_bits=64,
        chain=proofs[0],
        bounds=bounds,
        broken=None,
        link_length=Tolerance(1e-4, 1.1e-4, np.inf, proofs[1]),
        coordinates=Tolerance(1e-4, 1.1e-4, np.inf, proofs[2]),
    )


def make_trajectory(path: Path) -> Trajectory:
    """Speed up for a second, slow down for a second."""
    points = ([0.0, 1.0, 2.0], [0.0, 0.5, 1.0], [0.0, 1.0, 0.0], [1.0, -1.0, 0.0])
    return Trajectory.from_breakpoints(path, *(np.array(values) for values in points))


@dataclass
class Stages:
    """What the fake stages were asked, and how they are to behave."""

    calls: list[str] = field(default_factory=list)
    verbose: list[bool] = field(default_factory=list)
    failures: dict[str, BaseException] = field(default_factory=dict)
    messages: dict[str, list[tuple[str, float | None]]] = field(default_factory=dict)
    objective: float = 100.0
    grids: int = 0
    proofs: list[str] = field(default_factory=list)

    def enter(self, name: str, progress: Progress) -> None:
        """Count a call, talk, and fail where that is asked for."""
        self.calls.append(name)
        for message, fraction in self.messages.get(name, [("working", None), ("still working", 0.5)]):
            progress(message, fraction)
        if name in self.failures:
            raise self.failures[name]

    def taken(self) -> list[str]:
        """Give the calls since the last time."""
        calls, self.calls = self.calls, []
        return calls


@pytest.fixture
def stages(monkeypatch: pytest.MonkeyPatch, tmp_path: pathlib.Path) -> Stages:
    """Put fake stages in the place of the real ones."""
    fake = Stages()
    # The folder beside run folders may be shared by all tests: what fakes make must not get out.
    monkeypatch.setattr("pipeline.artifacts.region_cache.FOLDER", f"{tmp_path.name}.regions")

    def grid_regions(config: Config, machine: Machine, progress: Progress = silent) -> RegionTable:
        fake.grids += 1
        return make_regions(machine, 3)

    def build_regions(
        config: Config, machine: Machine, progress: Progress = silent, grid: RegionTable | None = None
    ) -> RegionTable:
        assert grid is not None
        assert len(grid) == 3
        fake.enter("regions", progress)
        return make_regions(machine)

    def plan_route(
        config: Config, machine: Machine, regions: RegionTable, progress: Progress = silent, verbose: bool = False
    ) -> Route:
        assert len(regions) == 5
        fake.verbose.append(verbose)
        fake.enter("route", progress)
        return make_route(machine, fake.objective)

    def refine_path(config: Config, machine: Machine, route: Route, monitor: Monitor = QUIET) -> Refinement:
        assert len(route) == 4
        fake.verbose.append(monitor.verbose)
        fake.enter("refine", monitor.progress)
        return make_refinement(machine)

    def certify_path(config: Config, machine: Machine, path: Path, progress: Progress = silent) -> Certificate:
        fake.enter("certify", progress)
        fake.proofs.append(config.certify.what)
        return make_certificate(path)

    def retime_path(config: Config, path: Path, progress: Progress = silent, verbose: bool = False) -> Trajectory:
        fake.enter("retime", progress)
        return make_trajectory(path)

    def all_figures(*results: object) -> dict[str, Figure]:
        fake.enter("figures", silent)
        return {"route": Figure((1, 1)), "kappa": Figure((1, 1))}

    monkeypatch.setattr("pipeline.route.grid_regions", grid_regions, raising=False)
    monkeypatch.setattr("pipeline.route.build_regions", build_regions, raising=False)
    monkeypatch.setattr("pipeline.route.plan_route", plan_route, raising=False)
    monkeypatch.setattr("pipeline.refine.refine_path", refine_path, raising=False)
    monkeypatch.setattr("pipeline.certify.certify_path", certify_path)
    monkeypatch.setattr("pipeline.retime.retime_path", retime_path)
    monkeypatch.setattr("pipeline.figures.all_figures", all_figures)
    monkeypatch.setattr("pipeline.run.reporting.report_page", lambda results, state: b"<!doctype html>")
    return fake


@pytest.fixture(scope="session")
def make() -> dict[str, Callable[..., Any]]:
    """Give tests the makers of results."""
    return {
        "regions": make_regions,
        "route": make_route,
        "refinement": make_refinement,
        "certificate": make_certificate,
        "trajectory": make_trajectory,
        "path": make_path,
    }
