"""The nonlinear program against NumPy."""

from dataclasses import replace

import casadi as ca
import numpy as np
import pytest
from scipy.interpolate import BSpline

from pipeline.config import Config
from pipeline.machine import Machine, condition_number, link_distances, statics_matrix
from pipeline.machine.clearance import link_pairs, link_rail_distances, rail_pairs
from pipeline.machine.kinematics import newton
from pipeline.refine import Path
from pipeline.refine.corridor import corridor
from pipeline.refine.integral.program import InitialGuess, Program, ProgramData, build_program
from pipeline.refine.integral.separation import find_separations
from pipeline.refine.splines import DEGREE, clamped_knots, fit
from pipeline.route import Route
from pipeline.route.metric import arc_length

FREE = np.full((2, 5), np.nan)


@pytest.fixture(scope="module")
def setting(quick_config: Config, machine: Machine, route: Route, coarse: Path, steps: np.ndarray):
    """Give a small program with its setting and its start, which closes all links."""
    s, knots = np.linspace(0.0, 1.0, 12), clamped_knots(9)
    coefficients = fit(knots, coarse.node_s, coarse.q(coarse.node_s))
    q = BSpline(knots, coefficients, DEGREE)(s)
    near = np.stack([np.interp(s, coarse.node_s, column) for column in coarse.node_pose.T], axis=1)
    pose, _ = newton(machine, q, near)
    box = corridor(quick_config, route, coarse, s)
    separations = find_separations(machine, pose, q, 0.001, 0.2)
    made = ProgramData(
        s,
        knots,
        box,
        separations,
        steps,
        2.0,
        directions=np.full((2, 5), np.nan),
        evenness=3.0,
    )
    return made, InitialGuess(pose, coefficients), q


@pytest.fixture(scope="module")
def program(machine: Machine, setting) -> Program:
    """Write the program."""
    return build_program(machine, setting[0], setting[1])


def _values(program: Program, name: str, x: np.ndarray) -> np.ndarray:
    """Evaluate the objective "f" or the constraints "g"."""
    return np.array(ca.Function(name, [program.problem["x"]], [program.problem[name]])(x)).ravel()


def test_the_integral_is_the_trapezoidal_one_of_kappa(machine: Machine, setting, program: Program) -> None:
    """It agrees with the integral computed from NumPy's Frobenius condition numbers."""
    made, start, q = setting
    H = statics_matrix(machine, start.pose, q[:, :3])
    kappa = np.linalg.norm(H, axis=(1, 2)) * np.linalg.norm(np.linalg.inv(H), axis=(1, 2))
    assert (kappa >= condition_number(H)).all()
    expected = np.trapezoid(kappa, arc_length(start.pose, made.steps))
    assert float(program.integral(program.start)) == pytest.approx(expected, rel=1e-8)


def test_uneven_speed_costs_its_variance_times_the_length(setting, program: Program) -> None:
    """What the objective has beyond the integral is the weighted variance of the speed along s."""
    made, start, _ = setting
    length, ds = arc_length(start.pose, made.steps), np.diff(made.s)
    speed = np.diff(length) / ds / length[-1]
    expected = 3.0 * length[-1] * np.sum(ds * (speed - 1.0) ** 2)
    extra = _values(program, "f", program.start) - float(program.integral(program.start))
    assert extra == pytest.approx(expected, rel=1e-7)


def test_equations_hold_at_a_start_that_closes(program: Program) -> None:
    """Closure, spline and length are satisfied by construction of the start."""
    g = _values(program, "g", program.start)
    for block in program.blocks:
        if block.name in ("closure", "spline", "length"):
            assert np.abs(g[block.begin : block.end]).max() < 1e-6, block.name


def test_clearance_rows_are_the_distances_at_the_start(setting, program: Program, machine: Machine) -> None:
    """With the best separating vectors the least row of a pair is its distance less what is asked for."""
    made, start, q = setting
    g = _values(program, "g", program.start)
    block = next(block for block in program.blocks if block.name == "clearance")
    rows = g[block.begin : block.end].reshape(4, len(made.separations))
    distances = link_distances(machine, start.pose, q[:, :3])
    column = [
        link_pairs(machine).index((a, b)) for a, b in zip(made.separations.first, made.separations.second, strict=True)
    ]
    expected = distances[made.separations.node, column] - made.separations.distance_m
    np.testing.assert_allclose(rows.min(axis=0), expected, atol=1e-9)


def test_rail_rows_are_the_distances_at_the_start(setting, machine: Machine) -> None:
    """A link and a rail have two rows, the least of which is their distance; their vector keeps no x."""
    made, start, q = setting
    guarded = replace(machine, link_rail_m=0.05)
    separations = find_separations(guarded, start.pose, q, 0.001, 10.0)
    program = build_program(guarded, replace(made, separations=separations), start)
    rails = np.flatnonzero(separations.of_rail)
    block = next(block for block in program.blocks if block.name == "clearance")
    rows = _values(program, "g", program.start)[block.begin : block.end][-2 * len(rails) :].reshape(2, -1)
    pairs = list(zip(separations.first[rails], separations.second[rails] - 6, strict=True))
    column = [rail_pairs(machine).index(pair) for pair in pairs]
    distances = link_rail_distances(machine, start.pose, q[:, :3])[separations.node[rails], column]
    np.testing.assert_allclose(rows.min(axis=0), distances - 0.051, atol=1e-9)
    high = program.variable_bounds[1]
    normal_high = high[11 * 12 + 5 * 9 :][: 3 * len(separations)].reshape(-1, 3)
    np.testing.assert_array_equal(normal_high[rails, 0], 0.0)
    assert np.isinf(np.delete(normal_high, rails, axis=0)).all()


def test_blocks_name_every_row_once(program: Program) -> None:
    """Messages can name any violated constraint."""
    edges = [0, *(block.end for block in program.blocks)]
    assert [block.begin for block in program.blocks] == edges[:-1]
    assert edges[-1] == program.problem["g"].numel() == len(program.constraint_bounds[0])


@pytest.mark.parametrize("exponent", [2.0, 64.0])
def test_derivatives_are_those_of_objective_and_constraints(machine: Machine, setting, exponent: float) -> None:
    """Gradient, Jacobian and Hessian agree with central differences along random directions."""
    program = build_program(machine, replace(setting[0], exponent=exponent), setting[1])
    rng, none, step = np.random.default_rng(3), ca.DM(0, 1), 1e-6
    multipliers = rng.normal(size=program.problem["g"].numel())
    gradient, jacobian, hessian = (program.derivatives[name] for name in ("grad_f", "jac_g", "hess_lag"))

    def lagrangian_gradient(x: np.ndarray) -> np.ndarray:
        return 1.3 * np.array(gradient(x, none)[1]).ravel() + np.array(jacobian(x, none)[1].T @ multipliers).ravel()

    H = np.array(ca.DM(hessian(program.start, none, 1.3, multipliers)))
    H = np.triu(H) + np.triu(H, 1).T
    for _ in range(3):
        direction = rng.normal(size=len(program.start))
        ahead, behind = program.start + step * direction, program.start - step * direction
        slopes = [(_values(program, name, ahead) - _values(program, name, behind)) / (2.0 * step) for name in "fg"]
        expected = float(np.array(gradient(program.start, none)[1]).ravel() @ direction)
        assert slopes[0][0] == pytest.approx(expected, rel=1e-6)
        found = np.array(jacobian(program.start, none)[1] @ direction).ravel()
        np.testing.assert_allclose(found, slopes[1], atol=1e-6 * np.abs(found).max())
        expected = (lagrangian_gradient(ahead) - lagrangian_gradient(behind)) / (2.0 * step)
        np.testing.assert_allclose(H @ direction, expected, atol=1e-4 * np.abs(expected).max())


def test_solutions_are_read_as_they_were_written(setting, program: Program) -> None:
    """Poses and coefficients come back from the vector of unknowns."""
    _, start, _ = setting
    np.testing.assert_array_equal(program.poses(program.start), start.pose)
    np.testing.assert_array_equal(program.spline_coefficients(program.start), start.coefficients)


def test_ends_are_fixed_and_coefficients_keep_strokes_and_travel(machine: Machine, setting, program: Program) -> None:
    """Bounds of coefficients hold everywhere, as a spline stays in the hull of its coefficients."""
    low, high = (program.spline_coefficients(bound) for bound in program.variable_bounds)
    np.testing.assert_array_equal(low[[0, -1]], high[[0, -1]])
    np.testing.assert_array_equal(low[1:-1], np.tile(machine.actuator_limits_m[:, 0], (7, 1)))
    np.testing.assert_array_equal(high[1:-1], np.tile(machine.actuator_limits_m[:, 1], (7, 1)))
