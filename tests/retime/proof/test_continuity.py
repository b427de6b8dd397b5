"""What counts as one motion: no jumps beyond rounding, and s on the path throughout."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.interpolate import PPoly

from pipeline.inclusion.closure import working_precision
from pipeline.retime import Trajectory, prove_motion
from pipeline.retime.proof.continuity import leaves_path
from pipeline.retime.proof.exact_motion import exact_motion
from tests.retime.proof.conftest import with_bump

_AT_S = 1.5


def _jumping(trajectory: Trajectory, row: int, by: float) -> Trajectory:
    """Change a coefficient of s(t) for a millisecond: its value (-1), its rate (-2), or half its acceleration (-3)."""
    split = with_bump(trajectory, _AT_S, 1e-3, 0.0)
    c = split.time_law.c.copy()
    c[row, 1] += by
    return replace(trajectory, time_law=PPoly(c, split.time_law.x))


def test_pieces_that_meet_jump_by_rounding_only(straight: Trajectory) -> None:
    """The same law in three pieces."""
    assert (prove_motion(with_bump(straight, _AT_S, 1e-3, 0.0)).jumps.largest < 1e-13).all()


@pytest.mark.parametrize(("order", "row", "factor"), [(0, -1, 1.0), (1, -2, 1.0), (2, -3, 2.0)])
def test_a_jump_is_measured_and_placed(straight: Trajectory, order: int, row: int, factor: float) -> None:
    """A metre per unit of s: the jump of the law is that of the carts."""
    jumps = prove_motion(_jumping(straight, row, 9e-6)).jumps
    assert jumps.largest[order] == pytest.approx(factor * 9e-6, rel=1e-2)
    assert jumps.t_s[order] == pytest.approx(_AT_S, abs=2e-3)
    assert (jumps.largest[:order] < jumps.allowed[:order]).all()


def test_a_law_that_turns_back_beyond_the_goal_leaves_the_path(straight: Trajectory) -> None:
    """A bump near the end carries s past one and back."""
    with working_precision(96):
        assert leaves_path(exact_motion(straight)) is None
        beyond = leaves_path(exact_motion(with_bump(straight, straight.duration_s - 0.1, 0.05, 0.01)))
    assert beyond == pytest.approx(straight.duration_s - 0.1, abs=0.05)


def test_a_motion_that_begins_or_ends_elsewhere_jumps_from_rest(straight: Trajectory) -> None:
    """Both ends count: the machine rests at s = 0 before, and at s = 1 after."""
    law = straight.time_law
    for c in (law.c + np.eye(6)[-1][:, None] * 1e-6, law.c * (1.0 - 1e-6)):
        jumps = prove_motion(replace(straight, time_law=PPoly(c, law.x))).jumps
        assert jumps.largest[0] == pytest.approx(1e-6, rel=1e-3)
