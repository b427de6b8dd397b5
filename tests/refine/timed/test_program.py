"""The program of path and time together, on straight moves along X, whose shortest times are known."""

from collections.abc import Callable
from dataclasses import replace

import casadi as ca
import numpy as np
import pytest
from scipy.interpolate import BSpline
from scipy.optimize import linprog

from pipeline.machine import Machine
from pipeline.machine.samples import PoseSamples
from pipeline.refine import Path
from pipeline.refine.collocation.data import NodeData
from pipeline.refine.collocation.ipopt import IpoptOptions, solve_program
from pipeline.refine.corridor.cells import Corridor
from pipeline.refine.mesh import Mesh
from pipeline.refine.splines import DEGREE
from pipeline.refine.timed.loads import load_shares
from pipeline.refine.timed.program import TimedData, TimedGuess, TimedProgram, build_timed_program
from pipeline.refine.timed.visits import VisitBounds, VisitNodes
from pipeline.status import Status

TRAVEL_M = 0.4
MotionMaker = Callable[[int], Path]
NO_VISITS = VisitNodes(np.zeros(0), np.zeros((0, 6)))


def _program(motion: Path, cap: float = 1e3, kappa: float = 0.0) -> TimedProgram:
    """Write the program of the move, from a motion along it, with a weight of the integral of kappa."""
    machine, tau, spline = motion.machine, motion.node_s, motion.spline
    low, high = np.full((len(tau), 6), -np.inf), np.full((len(tau), 6), np.inf)
    low[[0, -1]] = high[[0, -1]] = motion.node_pose[[0, -1]]
    data = TimedData(
        nodes=NodeData(
            mesh=Mesh(tau, spline.t),
            corridor=Corridor(low, high, np.zeros((len(tau), 3)), 0.0),
            limits=(),
            clearance_margin_m=0.0,
            reach_m=0.1,
            steps=np.array([0.1, 0.1, 0.1, 0.2, 0.2]),
            directions=np.full((2, 5), np.nan),
            actuator_range_m=machine.actuator_limits_m,
        ),
        exponent=64.0,
        log_cap=np.concatenate([[np.inf], np.full(len(tau) - 2, np.log(cap)), [np.inf]]),
        visit_bounds=VisitBounds(np.zeros((0, 6)), np.zeros((0, 6)), np.zeros((0, 5))),
        weights=(1.0, kappa),
    )
    return build_timed_program(data, TimedGuess(motion, NO_VISITS))


@pytest.fixture(scope="module")
def durations(straight_motion: MotionMaker) -> np.ndarray:
    """Solve on three meshes, each with about twice the coefficients."""
    return np.array([_solved(straight_motion(coefficients)) for coefficients in (12, 24, 48)])


def _solved(motion: Path) -> float:
    timed = _program(motion)
    result = solve_program(timed.program, IpoptOptions(300, 60.0, "timed"), "straight")
    assert result.status is Status.CONVERGED
    return float(timed.motion(result.x))


def _collocated(machine: Machine, pieces: int) -> float:
    """Find the shortest time of a cart by bisection: a linear program with a constant jerk in each of many pieces."""
    v, a, j = (float(part[0]) for part in (machine.velocity_mps, machine.acceleration_mps2, machine.jerk_mps3))
    low, high = 0.5, 5.0
    age = np.tril(np.ones((pieces, pieces)))
    while high - low > 3e-3:
        motion_s = (low + high) / 2.0
        h = motion_s / pieces
        rates = h * age
        speeds = h * age @ (rates - h / 2.0 * np.eye(pieces))
        travel = (h * np.sum(speeds - h / 2.0 * rates + h**2 / 6.0 * np.eye(pieces), axis=0))[None]
        bounded = np.vstack([rates / a, -rates / a, speeds / v, -speeds / v])
        ends = np.vstack([rates[-1:], speeds[-1:], travel])
        found = linprog(np.zeros(pieces), bounded, np.ones(len(bounded)), ends, [0.0, 0.0, TRAVEL_M], (-j, j))
        low, high = (low, motion_s) if found.status == 0 else (motion_s, high)
    return high


def test_durations_fall_with_the_mesh_to_the_shortest_one(machine: Machine, durations: np.ndarray) -> None:
    """From above: limits by control coefficients are never looser than limits at every instant."""
    v, a, j = (float(part[0]) for part in (machine.velocity_mps, machine.acceleration_mps2, machine.jerk_mps3))
    shortest = TRAVEL_M / v + v / a + a / j
    excess = durations / shortest - 1.0
    assert (excess > 0.0).all()
    assert (np.diff(excess) < 0.0).all()
    assert excess[2] < 0.02
    order = np.log2(excess[:-1] / excess[1:])
    assert (order > 0.8).all()


def test_the_shortest_time_is_that_of_a_dense_collocation(machine: Machine, durations: np.ndarray) -> None:
    """An independent transcription, with piecewise constant jerk, has the same least duration."""
    assert durations[-1] == pytest.approx(_collocated(machine, 60), rel=0.02)


def test_the_speed_of_the_tcp_is_a_limit_of_the_motion(machine: Machine, straight_motion: MotionMaker) -> None:
    """Half the carts' speed takes the time of a cart that is so slow; loads at the nodes are within their limits."""
    a, j = float(machine.acceleration_mps2[0]), float(machine.jerk_mps3[0])
    v = float(machine.velocity_mps[0]) / 2.0
    motion = straight_motion(12)
    motion = replace(motion, machine=replace(machine, tcp_speed_mps=v), motion_s=2.0 * float(motion.motion_s or 0.0))
    timed = _program(motion)
    result = solve_program(timed.program, IpoptOptions(300, 60.0, "timed"), "straight")
    assert result.status is Status.CONVERGED
    shortest = TRAVEL_M / v + v / a + a / j
    assert shortest < float(timed.motion(result.x)) < 1.08 * shortest
    spline = BSpline(motion.spline.t, timed.program.spline_coefficients(result.x), DEGREE)
    found = replace(motion, spline=spline, node_pose=timed.program.poses(result.x))
    assert load_shares(found, motion.node_s, float(timed.motion(result.x))).max() <= 1.0 + 1e-6


def test_derivatives_are_those_of_objective_and_constraints(straight_motion: MotionMaker) -> None:
    """Gradient, Jacobian and Hessian agree with differences, rows of the cap on kappa included."""
    timed = _program(straight_motion(12), cap=20.0, kappa=0.01)
    program, generator = timed.program, np.random.default_rng(5)
    x = program.guess + 1e-3 * generator.normal(size=program.guess.shape)
    direction, step = generator.normal(size=x.shape), 1e-7
    problem = ca.Function("fg", [program.problem["x"]], [program.problem["f"], program.problem["g"]])
    forward, backward = problem(x + step * direction), problem(x - step * direction)
    _, gradient = program.derivatives["grad_f"](x, [])
    _, jacobian = program.derivatives["jac_g"](x, [])
    by_f, by_g = (
        (np.array(one) - np.array(other)).ravel() / (2.0 * step) for one, other in zip(forward, backward, strict=True)
    )
    assert float(np.array(gradient).ravel() @ direction) == pytest.approx(by_f[0], rel=1e-4)
    np.testing.assert_allclose(np.array(jacobian @ direction).ravel(), by_g, rtol=1e-4, atol=1e-5 * np.abs(by_g).max())
    weights = generator.normal(size=program.problem["g"].numel())

    def slope(at: np.ndarray) -> np.ndarray:
        _, first = program.derivatives["grad_f"](at, [])
        _, rows = program.derivatives["jac_g"](at, [])
        return np.array(first).ravel() + np.array(rows.T @ weights).ravel()

    triangle = program.derivatives["hess_lag"](x, [], 1.0, weights)
    hessian = np.array(triangle + triangle.T - ca.diag(ca.diag(triangle)))
    expected = (slope(x + step * direction) - slope(x - step * direction)) / (2.0 * step)
    np.testing.assert_allclose(hessian @ direction, expected, rtol=1e-3, atol=1e-5 * np.abs(expected).max())


def test_kappa_gets_a_row_at_every_node_but_the_ends(machine: Machine, straight_motion: MotionMaker) -> None:
    """The rows are log kappa less the log of the cap; start and goal are given."""
    program = _program(straight_motion(12), cap=20.0).program
    block = next(block for block in program.blocks if block.name == "kappa above its cap")
    assert block.end - block.begin == 4 * 12 - 1
    g = np.array(ca.Function("g", [program.problem["x"]], [program.problem["g"]])(program.guess)).ravel()
    samples = PoseSamples(machine, program.poses(program.guess), program.guess[6 * 49 : 11 * 49].reshape(49, 5))
    np.testing.assert_allclose(g[block.begin : block.end], np.log(samples.kappa[1:-1] / 20.0), atol=0.06)


def test_a_locked_actuator_keeps_its_coefficients(machine: Machine, straight_motion: MotionMaker) -> None:
    """Without a velocity it cannot move, whatever its telescope would allow."""
    locked = replace(machine, velocity_mps=np.array([0.5, 0.5, 0.5, 0.1, 0.0]))
    low, high = _program(replace(straight_motion(12), machine=locked)).program.variable_bounds
    c = slice(11 * 49, 11 * 49 + 5 * 12)
    assert (low[c].reshape(12, 5)[:, 4] == high[c].reshape(12, 5)[:, 4]).all()
    assert (low[c].reshape(12, 5)[3:-3, 0] < high[c].reshape(12, 5)[3:-3, 0]).all()
