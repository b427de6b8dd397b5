"""Running IPOPT, on programs small enough to solve by hand."""

import signal
import threading
from dataclasses import replace

import casadi as ca
import numpy as np
import pytest

from pipeline.progress import Monitor
from pipeline.refine.collocation.ipopt import Accuracy, IpoptOptions, IpoptResult, solve_program
from pipeline.refine.collocation.program import Block, Program
from pipeline.status import Status


def _program(low: float = 2.0) -> Program:
    """Least x^4 + y^2 with y >= x^2 + `low` ("above") and x y = 3 ("hyperbola")."""
    x = ca.MX.sym("x", 2)
    f = x[0] ** 4 + x[1] ** 2
    g = ca.vertcat(x[1] - x[0] ** 2, x[0] * x[1])
    return Program(
        problem={"x": x, "f": f, "g": g},
        derivatives={},
        integral=ca.Function("integral", [x], [f]),
        variable_bounds=(np.array([0.0, 0.0]), np.array([5.0, 5.0])),
        constraint_bounds=(np.array([low, 3.0]), np.array([np.inf, 3.0])),
        guess=np.array([2.0, 1.0]),
        blocks=(Block("above", 0, 1), Block("hyperbola", 1, 2)),
        nodes=0,
        coefficients=0,
    )


def _solve(program: Program, iterations: int = 100, accuracy: Accuracy = "precise") -> IpoptResult:
    return solve_program(program, IpoptOptions(iterations, 60.0, accuracy), "test")


def test_a_small_program_is_solved() -> None:
    """With both constraints active the solution is y = x^2 + 2 and x y = 3, hence x = 1, y = 3."""
    result = _solve(_program())
    assert result.status is Status.CONVERGED
    np.testing.assert_allclose(result.x, [1.0, 3.0], atol=1e-6)
    assert max(result.violations.values()) < 1e-8


def test_a_rough_solve_ends_near_the_solution_and_not_later() -> None:
    """It is where another solve starts from: fewer iterations, the same place to a tenth."""
    rough, precise = _solve(_program(), accuracy="rough"), _solve(_program())
    assert rough.status is Status.CONVERGED
    assert rough.iterations <= precise.iterations
    np.testing.assert_allclose(rough.x, precise.x, atol=0.1)


def test_running_out_of_iterations_names_what_is_violated() -> None:
    """The last iterate and the violation of every named group are kept."""
    result = _solve(_program(), iterations=1)
    assert result.status is Status.NOT_CONVERGED
    assert result.message == "Maximum_Iterations_Exceeded"
    assert result.iterations == 1
    x, y = result.x
    expected = {"above": max(2.0 - (y - x**2), 0.0), "hyperbola": abs(x * y - 3.0)}
    assert result.violations == pytest.approx(expected, abs=1e-9)
    assert max(expected.values()) > 1e-3


def test_a_program_without_solution_is_not_reported_as_solved() -> None:
    """Within the bounds y - x^2 = 6 is out of reach."""
    result = _solve(_program(low=6.0))
    assert not result.status.solved
    assert result.violations["above"] > 0.5


def test_the_bounds_are_kept_to_the_last_digit() -> None:
    """IPOPT relaxes bounds by default; the travel of a cart cannot be relaxed."""
    tight = replace(_program(), variable_bounds=(np.array([1.0, 0.0]), np.array([1.0, 3.0])))
    result = _solve(tight)
    assert result.x[0] == 1.0
    assert result.x[1] <= 3.0


def test_every_iteration_is_reported() -> None:
    """The monitor receives the initial guess and each iteration."""
    heard: list[str] = []

    def listen(message: str, fraction: float | None = None) -> None:
        heard.append(message)

    result = solve_program(_program(), IpoptOptions(100, 60.0), "test", Monitor(listen))
    assert len(heard) == result.iterations + 1
    assert heard[0].startswith("test: IPOPT iteration 1, objective 17.0")


def test_an_interrupt_ends_the_solve_and_the_handler_is_put_back() -> None:
    """CasADi would swallow Ctrl-C; it is noted, raised afterwards, and works as before again."""
    before = signal.getsignal(signal.SIGINT)
    heard: list[str] = []

    def interrupt(message: str, fraction: float | None = None) -> None:
        heard.append(message)
        if len(heard) == 2:
            signal.raise_signal(signal.SIGINT)

    with pytest.raises(KeyboardInterrupt):
        solve_program(_program(), IpoptOptions(100, 60.0), "test", Monitor(interrupt))
    assert len(heard) == 2
    assert signal.getsignal(signal.SIGINT) is before


def test_it_solves_in_another_thread() -> None:
    """Only the main thread can handle signals; elsewhere nothing is touched."""
    found: list[IpoptResult] = []
    thread = threading.Thread(target=lambda: found.append(_solve(_program())))
    thread.start()
    thread.join()
    assert found[0].status is Status.CONVERGED
