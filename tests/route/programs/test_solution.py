"""Solving a program for one region and one x per step."""

import numpy as np
import pytest
from scipy.sparse import csc_array

from pipeline.route.programs.solution import solve_steps
from pipeline.solvers import LinearProgram
from pipeline.status import Status


def _program(least):
    """Ask for the least sum of three numbers of at most one each, that is at least something."""
    return LinearProgram(
        csc_array(np.ones((1, 3))),
        np.ones(3),
        (np.zeros(3), np.ones(3)),
        (np.array([least]), np.array([np.inf])),
        np.ones(3, dtype=bool),
    )


def test_steps_are_read_up_to_the_first_at_the_goal():
    """The goal is where the last step is; waiting in it is left out."""
    read = {"region": np.array([4, 0, 0, 5, 5, 5]), "x": np.arange(6.0)}
    seen = []

    def reader(values):
        seen.append(values)
        return read["region"], read["x"]

    sequence = solve_steps(_program(2.0), reader, 10.0)
    assert sequence.region.tolist() == [4, 0, 0, 5]
    assert sequence.x_m.tolist() == [0.0, 1.0, 2.0, 3.0]
    assert sequence.columns == 3
    assert sequence.outcome.objective == pytest.approx(seen[0].sum()) == pytest.approx(2.0)


def test_an_infeasible_program_has_no_steps():
    """Nothing is read."""
    sequence = solve_steps(_program(4.0), lambda values: pytest.fail("there is nothing to read"), 10.0)
    assert sequence.outcome.status is Status.INFEASIBLE
    assert len(sequence.region) == len(sequence.x_m) == 0
