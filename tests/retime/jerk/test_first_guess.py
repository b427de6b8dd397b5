"""The first guess: a law near the fastest, with continuous jerk, on breakpoints that ascend."""

from dataclasses import replace

import numpy as np
import pytest

from pipeline.refine.result import Path
from pipeline.retime import measure_usage
from pipeline.retime.fastest import plan
from pipeline.retime.jerk.first_guess import first_guess
from pipeline.retime.path_dynamics import grid, tabulate_dynamics
from pipeline.retime.result import Trajectory


@pytest.mark.parametrize("travel_m", [0.9, 0.01, 1e-4])
def test_a_line_is_guessed_within_its_limits(line, travel_m: float) -> None:
    """On a straight line blurring keeps velocity and acceleration limits, and jerk nearly so."""
    path = line(travel_m)
    guess = first_guess(tabulate_dynamics(path, grid(501)), plan(path, 500), 100)
    usage = measure_usage(Trajectory(path, guess.time_law()))
    assert usage.fractions["velocity"].max() <= 1.0 + 1e-3
    assert usage.fractions["acceleration"].max() <= 1.0 + 2e-2
    assert usage.fractions["jerk"].max() <= 2.5


def test_breakpoints_ascend_from_zero_to_one_at_rest(path: Path) -> None:
    """The ends are exact and still; speeds are never negative; there are about as many pieces as asked for."""
    guess = first_guess(tabulate_dynamics(path, grid(501)), plan(path, 500), 200)
    assert (guess.s[0], guess.s[-1]) == (0.0, 1.0)
    assert np.all(np.diff(guess.s) > 0.0)
    assert np.all(guess.h > 0.0)
    assert np.all(guess.v >= 0.0)
    assert not np.any([part[[0, -1]] for part in (guess.v, guess.w, guess.j)])
    assert 200 <= len(guess.h) <= 240


def test_breakpoints_are_dense_where_the_path_bends(path: Path) -> None:
    """Pieces are not all equally long: where q'' and q''' matter they are shorter."""
    guess = first_guess(tabulate_dynamics(path, grid(501)), plan(path, 500), 200)
    assert guess.h.max() > 1.1 * guess.h.min()


def test_a_slow_motion_has_pieces_enough_where_acceleration_changes(path: Path) -> None:
    """Two minutes long, with ramps of a twentieth of a second: at both ends several pieces share each of them."""
    slow = replace(path, machine=replace(path.machine, tcp_speed_mps=0.01))
    fastest = plan(slow, 1_000)
    guess = first_guess(tabulate_dynamics(slow, grid(1_001)), fastest, 100)
    assert fastest.duration_s > 100.0
    assert max(guess.h[:8].sum(), guess.h[-8:].sum()) < 0.3
    assert len(guess.h) < 200
