"""What a path costs that is not smooth."""

from itertools import pairwise

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.interpolate import BSpline

from pipeline.config import Config
from pipeline.machine import Machine
from pipeline.refine import Path, Refinement, refine_path
from pipeline.refine.measure import measure_path, sample_path
from pipeline.refine.smoothness import Smoothness
from pipeline.refine.splines import DEGREE, clamped_knots
from pipeline.route import Route

VELOCITY = np.array([0.5, 0.5, 0.4, 0.1, 0.2])


def test_the_form_is_the_integral_of_the_third_derivative_squared() -> None:
    """By adaptive quadrature from knot to knot, on uneven knots."""
    knots = np.concatenate([np.zeros(6), [0.1, 0.15, 0.6], np.ones(6)])
    spline = BSpline(knots, np.random.default_rng(1).normal(size=(9, 5)), DEGREE)
    edges = np.unique(knots)
    expected = sum(
        quad(lambda s: float(((spline(s, nu=3) / VELOCITY) ** 2).sum()), low, high)[0] for low, high in pairwise(edges)
    )
    c = spline.c.ravel()
    assert c @ (Smoothness(3.0, VELOCITY).form(knots) @ c) == pytest.approx(3.0 * expected, rel=1e-9)


def test_straight_motions_cost_nothing_and_no_motion_gains() -> None:
    """The form is positive semidefinite, and parabolas are in its null space."""
    knots = clamped_knots(12)
    form = Smoothness(1.0, VELOCITY).form(knots)
    assert np.linalg.eigvalsh(form.toarray()).min() > -1e-6 * np.abs(form.toarray()).max()
    # Coefficients of s itself are the means of five neighbouring knots (Greville).
    greville = np.array([knots[k + 1 : k + 6].mean() for k in range(12)])
    assert np.abs(form @ np.outer(greville, VELOCITY).ravel()).max() < 1e-6


def test_the_weight_is_relative_to_the_coarse_path(coarse: Path) -> None:
    """It is w times the integral of kappa, over the squared length in units of the velocity limits; none without w."""
    found = Smoothness.of(1e-6, 400.0, coarse)
    speed = np.linalg.norm(coarse.q(np.linspace(0.0, 1.0, 20_001), 1) / found.velocity_mps, axis=1).mean()
    assert found.weight == pytest.approx(1e-6 * 400.0 / speed**2, rel=5e-3)
    assert Smoothness.of(0.0, 400.0, coarse).form(clamped_knots(10)).count_nonzero() == 0


def test_smoothness_costs_little_and_brings_much(
    light_config: Config, machine: Machine, route: Route, refinement: Refinement, steps: np.ndarray
) -> None:
    """Against the same path without it: at most 2 % of the integral for a tenth of the third derivative squared."""
    refine = light_config.refine.model_copy(update={"smoothness": 0.0})
    rough = refine_path(light_config.model_copy(update={"refine": refine}), machine, route).path
    s = np.linspace(0.0, 1.0, 2_001)
    integrals = [measure_path(sample_path(path, s), steps).kappa_integral for path in (refinement.path, rough)]
    thirds = [((path.q(s, 3) / machine.velocity_mps) ** 2).sum() for path in (refinement.path, rough)]
    assert integrals[0] < 1.02 * integrals[1]
    assert thirds[0] < 0.1 * thirds[1]
