"""Short paths with known answers, and a function that proves them."""

import pathlib
import shutil
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import brentq

from pipeline.certify import Certificate, certify_path, prove_path
from pipeline.config import Config
from pipeline.inclusion.closure import working_precision
from pipeline.inclusion.uncertainty import of_everything, of_lengths
from pipeline.machine import Machine
from pipeline.refine import Path
from tests.certify.paths import NODES, START, determinant, ends_of, line_path, pose_path
from tests.certify.runs import prove_tolerance, write_run


@pytest.fixture(scope="session")
def singular_at(machine: Machine) -> float:
    """Find where on the line det H is zero."""
    return float(brentq(lambda along: determinant(machine, along), 0.2, 0.9, xtol=1e-14))


@pytest.fixture(scope="session")
def line(machine: Machine) -> Path:
    """Make the short regular path."""
    return line_path(machine)


@pytest.fixture(scope="session")
def wide(agder_config: Config) -> Config:
    """Take the reference task with limits that no path of the tests meets, unless they are set."""
    machine = agder_config.machine
    machine = machine.model_copy(update={"clearance": machine.clearance.model_copy(update={"link_link_m": 0.0})})
    route = agder_config.route.model_copy(update={"kappa_max": 1e9})
    task = agder_config.task.model_copy(update={"tilt_max_deg": 85.0})
    return agder_config.model_copy(update={"machine": machine, "route": route, "task": task})


@pytest.fixture(scope="session")
def prove(wide: Config) -> Callable[..., Certificate]:
    """Give a function that proves a path between its own ends; force limits count if `held`."""

    def run(
        machine: Machine, path: Path, modes: tuple[int, int] = (0, 0), *, held: bool = False, **certify: object
    ) -> Certificate:
        if not held:
            machine = replace(machine, force_n=np.full(5, np.inf), link_force_n=np.inf)
        config = wide.model_copy(update={"certify": wide.certify.model_copy(update=certify)})
        with working_precision(config.certify.precision_bits):
            return prove_path(config, machine, path, ends_of(machine, path, modes))

    return run


@pytest.fixture(scope="session")
def own_task(agder_config: Config) -> Config:
    """Ask for what the short path does, within the real limits."""
    start = agder_config.task.start
    goal = start.model_copy(update={"x_m": 1.05, "y_m": 0.33, "z_m": 0.88, "rx_deg": 2.0, "rz_deg": -1.0})
    return agder_config.model_copy(update={"task": agder_config.task.model_copy(update={"goal": goal})})


@pytest.fixture(scope="session")
def own_path(machine: Machine, goal: np.ndarray) -> Path:
    """Go straight from its start to its goal."""
    return pose_path(machine, np.linspace(START, goal, NODES), 0)


@pytest.fixture(scope="session")
def goal() -> np.ndarray:
    """Say where the task of these tests ends."""
    return np.array([1.05, 0.33, 0.88, *np.deg2rad([2.0, -1.0])])


@pytest.fixture(scope="session")
def true_run(
    tmp_path_factory: pytest.TempPathFactory, own_task: Config, machine: Machine, goal: np.ndarray
) -> pathlib.Path:
    """Certify a path of six pieces, with both tolerances, and write it as a run does."""
    path = pose_path(machine, np.linspace(START, goal, 11), 0, 11)
    certificate = certify_path(own_task, machine, path)
    certificate = replace(
        certificate,
        link_length=prove_tolerance(path, of_lengths(1e-4)),
        coordinates=prove_tolerance(path, of_everything(2e-5)),
    )
    folder = tmp_path_factory.mktemp("runs") / "true"
    write_run(folder, own_task, path, certificate)
    return folder


@pytest.fixture
def run(true_run: pathlib.Path, tmp_path: pathlib.Path) -> pathlib.Path:
    """Give a copy of the true run, to be forged."""
    return pathlib.Path(shutil.copytree(true_run, tmp_path / "run"))
