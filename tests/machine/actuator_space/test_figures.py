"""What the drives feel: by definition, and by moving the actuators."""

from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from pipeline.machine.actuator_space import (
    amplification,
    drive_figures,
    gravity_stiffness,
    mass_matrix,
    mode_words,
    velocity_forces,
)
from pipeline.machine.kinematics import pose_jacobian

seeds = st.integers(0, 2**32 - 1)
kinds = st.sampled_from(["on axis", "off axis", "general"])


@given(seed=seeds, kind=kinds)
@example(seed=68365, kind="general")
@settings(max_examples=8)
def test_figures_belong_to_their_directions(draw_moving: Callable, seed: int, kind: str):
    """Each value is what its matrix gives along its direction, and no random direction is beyond it."""
    moving = draw_moving(seed, kind)
    machine, rates, qd = moving.machine, moving.rates, moving.qd_mps
    felt = drive_figures(machine, rates, qd)
    M, K = mass_matrix(machine, rates), gravity_stiffness(machine, rates)
    assert (felt.reflected_mass_kg <= felt.worst_mass_kg.value[:, None] * (1.0 + 1e-12)).all()

    def along(matrices: np.ndarray, x: np.ndarray) -> np.ndarray:
        return np.einsum("ni,nij,nj->n", x, matrices, x)

    def damped(x: np.ndarray) -> np.ndarray:
        """By the definition of a derivative: x' c(qd + x) is quadratic, so that central differences are exact."""
        ahead, behind = (velocity_forces(machine, rates, qd + sign * x) for sign in (1.0, -1.0))
        return np.einsum("ni,ni->n", x, ahead - behind) / 2.0

    random = np.random.default_rng(seed).normal(size=qd.shape)
    random /= np.linalg.norm(random, axis=1, keepdims=True)
    for figure, of, sign in (
        (felt.worst_mass_kg, lambda x: along(M, x), 1.0),
        (felt.stiffness_npm, lambda x: along(K, x), -1.0),
        (felt.damping_nspm, damped, -1.0),
    ):
        # Where nothing moves there is nothing but rounding.
        rounding = 1e-8 * np.abs(figure.value).max() + 1e-9
        assert of(figure.along) == pytest.approx(figure.value, abs=rounding)
        assert (sign * of(random) <= sign * figure.value + rounding).all()


@given(seed=seeds, kind=kinds)
@settings(max_examples=8)
def test_amplification_is_how_far_the_tcp_moves(draw_moving: Callable, seed: int, kind: str):
    """By actuator it is the length of the pose Jacobian's column, and the worst direction is not below any of them."""
    moving = draw_moving(seed, kind)
    gains, h = amplification(moving.rates), 1e-6
    columns = pose_jacobian(moving.machine, moving.pose, moving.q_m)[:, :3]
    np.testing.assert_allclose(gains.position_by_drive, np.linalg.norm(columns, axis=1), rtol=1e-9)
    assert (gains.position.value[:, None] >= gains.position_by_drive * (1.0 - 1e-12)).all()
    assert (gains.angle.value[:, None] >= gains.angle_by_drive * (1.0 - 1e-12)).all()
    before, after = (moving.at(sign * h * gains.position.along)[0] for sign in (-1.0, 1.0))
    moved = np.linalg.norm(after[:, :3] - before[:, :3], axis=1) / (2.0 * h)
    assert moved == pytest.approx(gains.position.value, rel=1e-5)


def test_directions_in_words():
    """The larger parts, the largest of them positive."""
    assert mode_words(np.array([0.09, -0.15, 0.06, -0.53, -0.83])) == "0.53 l2b + 0.83 l3b"
    assert mode_words(np.array([0.0, 1.0, 0.0, 0.0, 0.0])) == "1.00 c2"
    assert mode_words(np.array([0.6, -0.8, 0.0, 0.0, 0.0])) == "- 0.60 c1 + 0.80 c2"
