"""Running IPOPT: every iteration is reported, and Ctrl-C ends it, whatever class it is raised as."""

import signal
import threading
from types import FrameType
from typing import Any

import casadi as ca
import pytest

from pipeline.solvers import Iteration, run_ipopt


def _run(listener: Iteration = lambda number, objective: None) -> tuple[dict[str, ca.DM], dict[str, Any]]:
    """Least x^4 + y^2 with x + y = 1."""
    x = ca.MX.sym("x", 2)
    problem = {"x": x, "f": x[0] ** 4 + x[1] ** 2, "g": x[0] + x[1]}
    given = {"x0": [3.0, 1.0], "lbx": [-5.0, -5.0], "ubx": [5.0, 5.0], "lbg": [1.0], "ubg": [1.0]}
    return run_ipopt("test", problem, {"ipopt": {"print_level": 0}}, given, listener)


def test_every_iteration_is_reported() -> None:
    """The listener hears of the start and of each iteration, with the objective there."""
    heard: list[tuple[int, float]] = []
    result, stats = _run(lambda number, objective: heard.append((number, objective)))
    assert [number for number, _ in heard] == list(range(1, stats["iter_count"] + 2))
    assert heard[-1][1] == pytest.approx(float(result["f"]))
    assert stats["return_status"] == "Solve_Succeeded"


def test_ctrl_c_ends_the_solve_though_a_handler_of_its_own_raises() -> None:
    """The command line raises a class of its own, which must not end up as a failed solve."""

    class Interrupt(KeyboardInterrupt):
        pass

    def handler(_signal: int, _frame: FrameType | None) -> None:
        raise Interrupt

    before = signal.signal(signal.SIGINT, handler)
    try:
        with pytest.raises(KeyboardInterrupt):
            _run(lambda number, objective: signal.raise_signal(signal.SIGINT) if number == 2 else None)
        assert signal.getsignal(signal.SIGINT) is handler
    finally:
        signal.signal(signal.SIGINT, before)


def test_it_solves_in_another_thread() -> None:
    """Only the main thread can handle signals; elsewhere nothing is touched."""
    found: list[dict[str, Any]] = []
    thread = threading.Thread(target=lambda: found.append(_run()[1]))
    thread.start()
    thread.join()
    assert found[0]["return_status"] == "Solve_Succeeded"
