"""The nonlinear program against NumPy."""

from dataclasses import replace

import casadi as ca
import numpy as np
import pytest
from scipy.interpolate import BSpline

from pipeline.config import Config
from pipeline.limits import node_limits
from pipeline.limits.actuator_margins import planned_range_m
from pipeline.limits.axis_distance import AxisDistance
from pipeline.machine import Machine, condition_number
from pipeline.machine.kinematics import newton
from pipeline.machine.samples import PoseSamples
from pipeline.refine import Path
from pipeline.refine.collocation.data import NodeData
from pipeline.refine.collocation.program import Program
from pipeline.refine.corridor.cells import corridor
from pipeline.refine.corridor.cone import Walls
from pipeline.refine.integral.program import InitialGuess, ProgramData, build_program
from pipeline.refine.mesh import Mesh
from pipeline.refine.smoothness import Smoothness
from pipeline.refine.splines import DEGREE, clamped_knots, fit
from pipeline.route import Route
from pipeline.route.metric import arc_length

FREE = np.full((2, 5), np.nan)


@pytest.fixture(scope="module")
def data(quick_config: Config, machine: Machine, route: Route, coarse: Path, steps: np.ndarray) -> ProgramData:
    """Give the data of a small program."""
    s = np.linspace(0.0, 1.0, 12)
    return ProgramData(
        nodes=NodeData(
            mesh=Mesh(s, clamped_knots(9)),
            corridor=corridor(quick_config, route, coarse, s),
            limits=node_limits(quick_config, machine),
            clearance_margin_m=0.001,
            reach_m=0.2,
            steps=steps,
            directions=FREE,
            actuator_range_m=planned_range_m(quick_config, machine),
        ),
        exponent=2.0,
        evenness=3.0,
        smoothness=Smoothness(2.0, machine.velocity_mps).form(clamped_knots(9)),
    )


@pytest.fixture(scope="module")
def guess(machine: Machine, coarse: Path, data: ProgramData) -> InitialGuess:
    """Fit the coarse path, and close all links at the nodes."""
    s, knots = data.nodes.mesh.s, data.nodes.mesh.knots
    coefficients = fit(knots, coarse.node_s, coarse.q(coarse.node_s))
    q = BSpline(knots, coefficients, DEGREE)(s)
    near = np.stack([np.interp(s, coarse.node_s, column) for column in coarse.node_pose.T], axis=1)
    pose, _ = newton(machine, q, near)
    return InitialGuess(PoseSamples(machine, pose, q), coefficients)


@pytest.fixture(scope="module")
def program(data: ProgramData, guess: InitialGuess) -> Program:
    """Write the program."""
    return build_program(data, guess)


def _keeping(data: ProgramData, **values: object) -> ProgramData:
    """Change what the nodes have to keep."""
    return replace(data, nodes=replace(data.nodes, **values))


def _values(program: Program, name: str, x: np.ndarray) -> np.ndarray:
    """Evaluate the objective "f" or the constraints "g"."""
    return np.array(ca.Function(name, [program.problem["x"]], [program.problem[name]])(x)).ravel()


def test_the_integral_is_the_trapezoidal_one_of_kappa(data: ProgramData, guess: InitialGuess, program: Program) -> None:
    """It agrees with the integral computed from NumPy's Frobenius condition numbers."""
    H = guess.nodes.H
    kappa = np.linalg.norm(H, axis=(1, 2)) * np.linalg.norm(np.linalg.inv(H), axis=(1, 2))
    assert (kappa >= condition_number(H)).all()
    expected = np.trapezoid(kappa, arc_length(guess.nodes.pose, data.nodes.steps))
    assert float(program.integral(program.guess)) == pytest.approx(expected, rel=1e-8)


def test_uneven_speed_and_roughness_are_what_the_objective_adds(
    data: ProgramData, guess: InitialGuess, program: Program
) -> None:
    """Beyond the integral there is the weighted variance of the speed along s, and what is not smooth."""
    length, ds = arc_length(guess.nodes.pose, data.nodes.steps), np.diff(data.nodes.mesh.s)
    speed = np.diff(length) / ds / length[-1]
    expected = 3.0 * length[-1] * np.sum(ds * (speed - 1.0) ** 2)
    c = guess.coefficients.ravel()
    expected += c @ (data.smoothness @ c)
    extra = _values(program, "f", program.guess) - float(program.integral(program.guess))
    assert extra == pytest.approx(expected, rel=1e-7)


def test_equations_hold_at_a_guess_that_closes(program: Program) -> None:
    """Closure, spline and length are satisfied by construction of the guess."""
    g = _values(program, "g", program.guess)
    for block in program.blocks:
        if block.name in ("closure", "spline", "length"):
            assert np.abs(g[block.begin : block.end]).max() < 1e-6, block.name


@pytest.mark.parametrize("checks_rails", [False, True])
def test_rows_and_unknowns_of_every_limit_are_in_the_program(
    quick_config: Config, data: ProgramData, guess: InitialGuess, checks_rails: bool
) -> None:
    """At the guess every pair within reach keeps its distance; vectors stand between coefficients and length."""
    machine = replace(guess.nodes.machine, link_rail_m=0.05 if checks_rails else np.nan)
    limits = node_limits(quick_config, machine)
    assert len(limits) == 2 + checks_rails
    guess = replace(guess, nodes=replace(guess.nodes, machine=machine))
    program = build_program(_keeping(data, limits=limits, reach_m=10.0), guess)
    g, first = _values(program, "g", program.guess), 11 * 12 + 5 * 9
    distances = [limit for limit in limits if isinstance(limit, AxisDistance)]
    for limit, (pairs, rows_of_a_pair) in zip(distances, ((14, 4), (12, 2)), strict=False):
        block = next(block for block in program.blocks if block.name == limit.wording.name)
        rows = g[block.begin : block.end].reshape(rows_of_a_pair, 10, pairs)
        expected = limit.values(guess.nodes)[1:-1] - limit.least - 0.001
        np.testing.assert_allclose(rows.min(axis=0), expected, atol=1e-9)
        high = program.variable_bounds[1][first : first + 3 * 10 * pairs].reshape(-1, 3)
        # A rail is endless along X: what separates a link from it has no x.
        np.testing.assert_array_equal(high[:, 0], np.inf if rows_of_a_pair == 4 else 0.0)
        assert np.isinf(high[:, 1:]).all()
        first += 3 * 10 * pairs
    assert first == len(program.guess) - 1


def test_blocks_name_every_row_once(program: Program) -> None:
    """Messages can name any violated constraint."""
    edges = [0, *(block.end for block in program.blocks)]
    assert [block.begin for block in program.blocks] == edges[:-1]
    assert edges[-1] == program.problem["g"].numel() == len(program.constraint_bounds[0])


def test_a_direction_bounds_a_leg_of_the_control_polygon(data: ProgramData, guess: InitialGuess) -> None:
    """Four equations across it and one inequality along it, at the end that has a direction."""
    leg = guess.coefficients[-1] - guess.coefficients[-2]
    directions = FREE.copy()
    directions[1] = leg / np.linalg.norm(leg)
    program = build_program(_keeping(data, directions=directions), guess)
    across, along = program.blocks[-2:]
    g = _values(program, "g", program.guess)
    np.testing.assert_allclose(g[across.begin : across.end], np.zeros(4), atol=1e-12)
    np.testing.assert_allclose(g[along.begin : along.end], [np.linalg.norm(leg)])
    assert "goal" in across.name


def test_the_walls_of_straight_ends_are_rows(data: ProgramData, guess: InitialGuess) -> None:
    """How far the TCP at their nodes is in front of them."""
    rng = np.random.default_rng(4)
    walls = Walls(np.array([2, 5, 5]), rng.normal(size=(3, 3)), rng.normal(size=3))
    program = build_program(_keeping(data, corridor=replace(data.nodes.corridor, walls=walls)), guess)
    block = next(block for block in program.blocks if block.name == "cones of straight ends")
    expected = (walls.normal * guess.nodes.pose[walls.node, :3]).sum(axis=1) - walls.offset
    np.testing.assert_allclose(_values(program, "g", program.guess)[block.begin : block.end], expected, atol=1e-12)


def test_solutions_are_read_as_they_were_written(guess: InitialGuess, program: Program) -> None:
    """Poses and coefficients come back from the vector of unknowns."""
    np.testing.assert_array_equal(program.poses(program.guess), guess.nodes.pose)
    np.testing.assert_array_equal(program.spline_coefficients(program.guess), guess.coefficients)


def test_ends_are_fixed_and_coefficients_keep_strokes_and_travel(
    quick_config: Config, machine: Machine, program: Program
) -> None:
    """Less their margins: bounds of coefficients hold everywhere, as a spline stays in the hull of its coefficients."""
    least, largest = planned_range_m(quick_config, machine).T
    assert (least > machine.actuator_limits_m[:, 0]).all()
    low, high = (program.spline_coefficients(bound) for bound in program.variable_bounds)
    np.testing.assert_array_equal(low[[0, -1]], high[[0, -1]])
    np.testing.assert_array_equal(low[1:-1], np.tile(least, (7, 1)))
    np.testing.assert_array_equal(high[1:-1], np.tile(largest, (7, 1)))


@pytest.mark.parametrize("exponent", [2.0, 64.0])
def test_derivatives_are_those_of_objective_and_constraints(
    data: ProgramData, guess: InitialGuess, exponent: float
) -> None:
    """Gradient, Jacobian and Hessian agree with central differences along random directions."""
    program = build_program(replace(data, exponent=exponent), guess)
    rng, none, step = np.random.default_rng(3), ca.DM(0, 1), 1e-6
    multipliers = rng.normal(size=program.problem["g"].numel())
    gradient, jacobian, hessian = (program.derivatives[name] for name in ("grad_f", "jac_g", "hess_lag"))

    def lagrangian_gradient(x: np.ndarray) -> np.ndarray:
        return 1.3 * np.array(gradient(x, none)[1]).ravel() + np.array(jacobian(x, none)[1].T @ multipliers).ravel()

    H = np.array(ca.DM(hessian(program.guess, none, 1.3, multipliers)))
    H = np.triu(H) + np.triu(H, 1).T
    for _ in range(3):
        direction = rng.normal(size=len(program.guess))
        ahead, behind = program.guess + step * direction, program.guess - step * direction
        slopes = [(_values(program, name, ahead) - _values(program, name, behind)) / (2.0 * step) for name in "fg"]
        expected = float(np.array(gradient(program.guess, none)[1]).ravel() @ direction)
        assert slopes[0][0] == pytest.approx(expected, rel=1e-6)
        found = np.array(jacobian(program.guess, none)[1] @ direction).ravel()
        np.testing.assert_allclose(found, slopes[1], atol=1e-6 * np.abs(found).max())
        expected = (lagrangian_gradient(ahead) - lagrangian_gradient(behind)) / (2.0 * step)
        np.testing.assert_allclose(H @ direction, expected, atol=1e-4 * np.abs(expected).max())
