"""Running HiGHS."""

import re

import highspy
import numpy as np
import pytest
from scipy.sparse import csc_array

from pipeline.progress import Monitor
from pipeline.solvers import LinearProgram, solve_program, solver_name, write_program
from pipeline.solvers.highs import report_incumbent
from pipeline.status import Status


def _knapsack(size=3, integer=True, seed=0):
    """Pack the most valuable things into a third of their total weight, as a minimisation."""
    random = np.random.default_rng(seed)
    weight, value = random.integers(5, 60, size), random.integers(5, 60, size)
    program = LinearProgram(
        csc_array(weight[None, :].astype(float)),
        -value.astype(float),
        (np.zeros(size), np.ones(size)),
        (np.array([-np.inf]), np.array([float(weight.sum() // 3)])),
        np.full(size, integer),
    )
    return program, weight, value


def _hard():
    """Market split: equations with large coefficients in booleans, which take branch and bound very long."""
    random = np.random.default_rng(1)
    weights = random.integers(0, 100, (5, 40)).astype(float)
    matrix = csc_array(np.hstack([weights, np.eye(5), -np.eye(5)]))
    half = np.floor(weights.sum(axis=1) / 2.0)
    upper = np.concatenate([np.ones(40), np.full(10, 1e4)])
    cost = np.concatenate([np.zeros(40), np.ones(10)])
    return LinearProgram(matrix, cost, (np.zeros(50), upper), (half, half), np.arange(50) < 40)


def test_a_mixed_integer_program_is_solved_to_a_gap_of_zero():
    """Against trying all subsets."""
    program, weight, value = _knapsack(12)
    outcome = solve_program(program, 60.0)
    subsets = (np.arange(2**12)[:, None] >> np.arange(12)) & 1
    best = (subsets @ value)[subsets @ weight <= weight.sum() // 3].max()
    assert outcome.status is Status.OPTIMAL
    assert outcome.objective == pytest.approx(-best)
    assert outcome.bound == pytest.approx(-best)
    assert outcome.gap == 0.0
    assert outcome.values @ value == pytest.approx(best)


def test_a_linear_program_has_its_optimum_for_a_bound():
    """No branching, no gap."""
    program, weight, value = _knapsack(12, integer=False)
    outcome = solve_program(program, 60.0)
    order = np.argsort(-value / weight)
    room, best = float(weight.sum() // 3), 0.0
    for thing in order:
        part = min(1.0, room / weight[thing])
        room, best = room - part * weight[thing], best + part * value[thing]
    assert outcome.status is Status.OPTIMAL
    assert outcome.objective == outcome.bound == pytest.approx(-best)
    assert outcome.gap == 0.0


@pytest.mark.parametrize("integer", [True, False])
def test_infeasible_programs_have_no_values(integer):
    """At most 1 and at least 2."""
    program = LinearProgram(
        csc_array(np.eye(1)),
        np.ones(1),
        (np.zeros(1), np.ones(1)),
        (np.array([2.0]), np.array([np.inf])),
        np.array([integer]),
    )
    outcome = solve_program(program, 60.0)
    assert outcome.status is Status.INFEASIBLE
    assert outcome.values.size == 0
    assert outcome.objective == np.inf


def test_unbounded_programs_count_as_not_converged():
    """Nothing in stage one is unbounded: it would be a mistake of ours, and not a proof of anything."""
    program = LinearProgram(
        csc_array(np.eye(1)),
        -np.ones(1),
        (np.zeros(1), np.full(1, np.inf)),
        (np.array([0.0]), np.array([np.inf])),
        np.array([False]),
    )
    assert solve_program(program, 60.0).status is Status.NOT_CONVERGED


def test_the_time_limit_ends_a_solve_and_progress_is_reported():
    """Status, best objective and bound say how far it came; incumbents and gaps are reported on the way."""
    seen = []
    outcome = solve_program(_hard(), 0.5, Monitor(lambda message, fraction=None: seen.append(message)))
    assert outcome.status is Status.TIME_LIMIT
    assert outcome.bound < outcome.objective
    assert outcome.gap > 0.0
    assert any(re.match(r"HiGHS: incumbent [\d.]+, bound -?[\d.]+, gap [\d.]+%", message) for message in seen)


def test_no_incumbent_and_no_gap_are_reported_as_such():
    """Before the first feasible point HiGHS reports infinities."""
    data = highspy.cb.HighsCallbackOutput()
    data.mip_primal_bound, data.mip_dual_bound, data.mip_gap = np.inf, 1.0, np.inf
    seen = []
    report_incumbent(data, lambda message, fraction=None: seen.append(message))
    assert seen == ["HiGHS: incumbent none yet, bound 1.000"]


def test_an_interruption_stops_the_solver_and_is_raised_again(monkeypatch):
    """Ctrl-C while waiting: the solver's thread has ended before the exception goes on."""
    wait, finished = highspy.Highs.wait, []

    def interrupted(solver, timeout=-1.0):
        if not finished:
            finished.append(False)
            raise KeyboardInterrupt
        done = wait(solver, timeout)
        finished.append(done[0])
        return done

    monkeypatch.setattr(highspy.Highs, "wait", interrupted)
    with pytest.raises(KeyboardInterrupt):
        solve_program(_hard(), 60.0)
    assert finished[-1]
    assert len(finished) > 1


def test_logs_are_printed_only_when_asked_for(capfd):
    """Standard output belongs to the caller."""
    program, _, _ = _knapsack()
    solve_program(program, 60.0)
    assert capfd.readouterr().out == ""
    solve_program(program, 60.0, Monitor(verbose=True))
    assert "HiGHS" in capfd.readouterr().out


def test_the_solver_is_named_with_its_version():
    """What a result was proven with is part of the result."""
    assert re.fullmatch(r"HiGHS \d+\.\d+\.\d+", solver_name())


def test_a_hessian_makes_it_a_quadratic_program():
    """The least (x - 1)^2 + (x - y)^2 over y >= 3, whose Hessian has a lower triangle of three entries."""
    program = LinearProgram(
        csc_array(np.zeros((1, 2))),
        np.array([-2.0, 0.0]),
        (np.array([-9.0, 3.0]), np.array([9.0, 9.0])),
        (np.zeros(1), np.zeros(1)),
        np.zeros(2, dtype=bool),
        csc_array(np.array([[4.0, 0.0], [-2.0, 2.0]])),
    )
    outcome = solve_program(program, 60.0)
    assert outcome.status is Status.OPTIMAL
    np.testing.assert_allclose(outcome.values, [2.0, 3.0], atol=1e-7)
    assert outcome.objective + 1.0 == pytest.approx(2.0)


@pytest.mark.parametrize("ending", ["mps", "lp"])
def test_a_program_is_written_for_other_solvers_and_read_back(tmp_path, ending):
    """The file has the same optimum; a folder that does not exist is an error."""
    program, _, _ = _knapsack(12)
    assert (program.rows, program.columns) == (1, 12)
    write_program(program, tmp_path / f"program.{ending}")
    solver = highspy.Highs()
    solver.setOptionValue("output_flag", False)
    solver.readModel(str(tmp_path / f"program.{ending}"))
    solver.run()
    assert solver.getInfo().objective_function_value == pytest.approx(solve_program(program, 60.0).objective)
    with pytest.raises(OSError, match="cannot be written"):
        write_program(program, tmp_path / "missing" / f"program.{ending}")
