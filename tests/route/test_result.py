"""What can be read off a route."""

import numpy as np
import pytest

from pipeline.machine import MODES
from pipeline.route import Route, Search
from pipeline.status import Status


@pytest.fixture
def route() -> Route:
    """Make a route that passes through LLL, LRL, LRR and RLL."""
    n = 5
    return Route(
        region=np.arange(n),
        modes=np.array([MODES.index(name) for name in ("LLL", "LLL", "LRL", "LRR", "RLL")]),
        gates=np.zeros(n, dtype=np.int64),
        visits=np.zeros(n, dtype=np.int64),
        pose=np.zeros((n, 6)),
        q_m=np.zeros((n, 5)),
        kappa=np.array([3.0, 5.0, 9.0, 4.0, 2.0]),
        objective=21.0,
        status=Status.OPTIMAL,
        search=Search("solver", 21.0, 0.0, 20.0, 22.0, 5, 7, 8, 1, 4, 0, 20.0),
    )


def test_length_modes_and_largest_kappa_are_read_off_the_steps(route):
    """The goal's kappa counts, although the sum leaves it out."""
    assert len(route) == 5
    assert route.mode_names == ["LLL", "LLL", "LRL", "LRR", "RLL"]
    assert route.kappa_max == 9.0


def test_every_arm_that_changes_its_mode_is_counted_each_time(route):
    """LLL-LRL is one, LRL-LRR one, LRR-RLL three."""
    assert route.mode_changes == 5


def test_a_solved_status_may_be_used_by_the_next_stage(route):
    """Only a proven route is ever handed on, and nothing has to be changed."""
    assert route.status.solved
    assert "Nothing" in route.status.advice
