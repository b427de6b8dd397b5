"""Reference values, random poses and random machines."""

import json
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import assume

from pipeline.arrays import FloatArray, IntArray
from pipeline.machine import InverseSolution, Machine, condition_number, inverse_kinematics, statics_matrix
from pipeline.machine.geometry import MODES, TRIANGLE

DATA = Path(__file__).parents[1] / "data" / "kinematics.json"


@dataclass(frozen=True, eq=False)
class Reference:
    """Forty poses of the reference machine, five per working mode, computed independently."""

    controlled: FloatArray
    modes: IntArray
    column: Callable[[str], FloatArray]


@dataclass(frozen=True, eq=False)
class Sample:
    """Reachable random poses of a machine: controlled (n, 5), modes (n,), poses (n, 6), actuators (n, 5)."""

    controlled: FloatArray
    modes: IntArray
    pose: FloatArray
    q_m: FloatArray
    kappa: FloatArray


@pytest.fixture(scope="session")
def reference() -> Reference:
    """Read the reference values."""
    poses = json.loads(DATA.read_text())["poses"]
    keys = ("x_m", "y_m", "z_m", "rx_rad", "rz_rad")
    return Reference(
        controlled=np.array([[pose[key] for key in keys] for pose in poses]),
        modes=np.array([MODES.index(pose["mode"]) for pose in poses]),
        column=lambda key: np.array([pose[key] for pose in poses]),
    )


@pytest.fixture(scope="session")
def reference_solution(machine: Machine, reference: Reference) -> InverseSolution:
    """Solve the inverse kinematics of all reference poses."""
    return inverse_kinematics(machine, reference.controlled, reference.modes)


@pytest.fixture(scope="session")
def draw_controlled() -> Callable[[int, int], tuple[FloatArray, IntArray]]:
    """Draw controlled poses (n, 5) around the workspace, and working modes (n,)."""

    def draw(seed: int, count: int) -> tuple[FloatArray, IntArray]:
        rng = np.random.default_rng(seed)
        low, high = [0.0, -0.4, 0.1, -0.5, -0.5], [2.0, 1.2, 1.5, 0.5, 0.5]
        return rng.uniform(low, high, (count, 5)), rng.integers(0, 8, count)

    return draw


@pytest.fixture(scope="session")
def draw_poses(
    draw_controlled: Callable[[int, int], tuple[FloatArray, IntArray]],
) -> Callable[..., Sample]:
    """Draw those of random poses that a machine reaches with kappa below a cap."""

    def draw(machine: Machine, seed: int, count: int = 150, kappa_max: float = 100.0) -> Sample:
        controlled, modes = draw_controlled(seed, count)
        solution = inverse_kinematics(machine, controlled, modes)
        rows = np.flatnonzero(solution.reachable)
        kappa = condition_number(statics_matrix(machine, solution.pose[rows], solution.q_m[rows, :3]))
        rows, kappa = rows[kappa < kappa_max], kappa[kappa < kappa_max]
        # A random machine may have no such pose among the drawn ones: then there is nothing to test.
        assume(len(rows) > 0)
        return Sample(controlled[rows], modes[rows], solution.pose[rows], solution.q_m[rows], kappa)

    return draw


@pytest.fixture(scope="session")
def draw_machine(machine: Machine) -> Callable[[int, str], Machine]:
    """Draw machines like the reference machine.

    "on axis" keeps a_3a on the platform's y axis and the triangle right-angled; "off axis" moves a_3a away from
    it; "general" gives links 3a and 3c different joints on the cart and the triangle any angle, too.
    """

    def draw(seed: int, kind: str) -> Machine:
        rng = np.random.default_rng(seed)
        points = machine.platform_points_m + rng.uniform(-0.03, 0.03, (6, 3))
        offsets = machine.cart_offsets_m + rng.uniform(-0.02, 0.02, (6, 3))
        lengths = machine.lengths_m * rng.uniform(0.97, 1.03, 6)
        if kind == "on axis":
            points[3, [0, 2]] = 0.0
        if kind != "general":
            offsets[TRIANGLE] = offsets[3]
            lengths[TRIANGLE] = np.hypot(lengths[3], np.linalg.norm(points[TRIANGLE] - points[3]))
        return replace(
            machine,
            rails_m=machine.rails_m + rng.uniform(-0.05, 0.05, (3, 2)),
            platform_points_m=points,
            cart_offsets_m=offsets,
            lengths_m=lengths,
            triangle_sign=rng.choice([-1.0, 1.0]),
        )

    return draw
