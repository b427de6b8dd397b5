"""Fixtures of bounds: the reference machine's chart, and poses on it."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import pytest

from pipeline.arrays import FloatArray
from pipeline.bound.chart import Chart, build_chart
from pipeline.bound.evaluate import Evaluator
from pipeline.config import Config
from pipeline.machine.clearance import link_distances
from pipeline.machine.geometry import TELESCOPES, Machine, build_machine, link_vectors, platform_arms, rotation
from pipeline.machine.statics import condition_number, det_sign, statics_matrix
from pipeline.route.regions.endpoints import Endpoint, task_endpoints


@dataclass(frozen=True, eq=False)
class Poses:
    """Poses (n, 6) of the reference machine with carts (n, 3), cart 3 at zero, and which keep the limits (n,)."""

    pose: FloatArray
    carts_m: FloatArray
    inside: FloatArray
    kappa: FloatArray
    sign: FloatArray


@pytest.fixture(scope="session")
def reference(quick_config: Config) -> tuple[Machine, tuple[Endpoint, Endpoint]]:
    """Build the reference machine and its ends."""
    machine = build_machine(quick_config.machine)
    return machine, task_endpoints(quick_config, machine)


@pytest.fixture(scope="session")
def chart(reference: tuple[Machine, tuple[Endpoint, Endpoint]]) -> Chart:
    """Build the chart of all five degrees of freedom."""
    return build_chart(reference[0], (np.deg2rad(30.0), np.deg2rad(30.0)), reference[1])


@pytest.fixture(scope="session")
def evaluator(chart: Chart, reference: tuple[Machine, tuple[Endpoint, Endpoint]]) -> Evaluator:
    """Evaluate boxes for kappa up to 28."""
    return Evaluator(chart, reference[1][0].det_sign, 28.0)


@pytest.fixture(scope="session")
def place() -> Callable[[Machine, FloatArray], tuple[FloatArray, FloatArray, FloatArray]]:
    """Give a function that computes poses (n, 6), joints (n, 6, 3) and D (2, n) from angles (4, n), by pose chart."""

    def compute(machine: Machine, angles: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        alpha, beta, rx, rz = angles
        ry = np.pi / 2.0 - alpha
        Q = rotation(rx, np.zeros_like(rx), rz)
        u = np.stack([np.cos(beta) * np.cos(alpha), np.sin(beta), np.cos(beta) * np.sin(alpha)], axis=-1)
        joint = 1.25 * (Q @ u[..., None])[..., 0]
        p = joint - rotation(rx, ry, rz) @ machine.platform_points_m[3]
        pose = np.column_stack([p, rx, ry, rz])
        A = platform_arms(machine, pose) + p[:, None]
        D = np.stack([1.09**2 - ((A[:, k, 1:] - machine.rails_m[k]) ** 2).sum(axis=1) for k in (0, 1)])
        return pose, A, D

    return compute


@dataclass(frozen=True, eq=False)
class Draw:
    """Draws boxes of the reference machine's chart, and poses from boxes, for a sign of det H."""

    machine: Machine
    place: Callable[[Machine, FloatArray], tuple[FloatArray, FloatArray, FloatArray]]
    judge: Callable[[Machine, FloatArray, FloatArray], Poses]
    sign: float

    def boxes(self, rng: np.random.Generator, count: int) -> tuple[FloatArray, FloatArray]:
        """Draw boxes (6, n) of many sizes and shapes around poses within reach."""
        angles = rng.uniform([-0.3, -0.6, -0.52, -0.52], [3.4, 0.9, 0.52, 0.52], (count, 4)).T
        D = self.place(self.machine, angles)[2]
        reached = (D > 0.0).all(axis=0)
        s = np.sqrt(D[:, reached]) * rng.choice([-1.0, 1.0], (2, int(reached.sum())))
        points = np.vstack([angles[:, reached], s])
        half = 10.0 ** (rng.uniform(-3.0, -0.7, points.shape[1]) + rng.uniform(-0.3, 0.3, points.shape))
        middle = points + rng.uniform(-1.0, 1.0, points.shape) * half
        return middle - half, middle + half

    def poses(self, rng: np.random.Generator, low: FloatArray, high: FloatArray, kappa: float) -> tuple[int, int]:
        """Draw 60 poses from each box (6, n), in all working modes: how many it holds, and how many it must not.

        These are within the limits, of the wanted sign, and of a kappa up to the given one.
        """
        box = np.repeat(np.arange(low.shape[1]), 60)
        angles = rng.uniform(low[:4, box], high[:4, box])
        pose, joints, D = self.place(self.machine, angles)
        tested = wrong = 0
        for signs in ((-1.0, -1.0), (-1.0, 1.0), (1.0, -1.0), (1.0, 1.0)):
            s = np.sqrt(np.maximum(D, 0.0)) * np.array(signs)[:, None]
            held = ((D >= 0.0) & (s >= low[4:, box]) & (s <= high[4:, box])).all(axis=0)
            carts = np.column_stack([joints[:, 0, 0] - s[0], joints[:, 1, 0] - s[1], np.zeros(len(box))])
            found = self.judge(self.machine, pose[held], carts[held])
            wrong += int((found.inside & (found.sign == self.sign) & (found.kappa <= kappa)).sum())
            tested += int(held.sum())
        return tested, wrong


@pytest.fixture(scope="session")
def draw(
    reference: tuple[Machine, tuple[Endpoint, Endpoint]],
    place: Callable[[Machine, FloatArray], tuple[FloatArray, FloatArray, FloatArray]],
    judge: Callable[[Machine, FloatArray, FloatArray], Poses],
) -> Draw:
    """Give what draws boxes and poses of the reference machine, for the sign of the start."""
    return Draw(reference[0], place, judge, reference[1][0].det_sign)


@pytest.fixture(scope="session")
def judge() -> Callable[[Machine, FloatArray, FloatArray], Poses]:
    """Give a function that checks poses (n, 6) with carts (n, 3) by the rest of the code."""

    def check(machine: Machine, pose: FloatArray, carts_m: FloatArray) -> Poses:
        H = statics_matrix(machine, pose, carts_m)
        v = link_vectors(machine, pose, carts_m)[:, TELESCOPES]
        lengths = np.sqrt((v**2).sum(axis=2))
        inside = np.ptp(carts_m, axis=1) <= 2.1
        inside &= ((lengths >= machine.strokes_m[:, 0]) & (lengths <= machine.strokes_m[:, 1])).all(axis=1)
        inside &= link_distances(machine, pose, carts_m).min(axis=1) >= machine.link_link_m
        return Poses(pose, carts_m, inside, condition_number(H), det_sign(H))

    return check
