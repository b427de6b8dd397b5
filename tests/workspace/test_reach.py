"""What a machine can use without tilt."""

import pytest

from pipeline.machine import MODES, Machine
from pipeline.workspace.reach import usable_reach

HIDE_CURSOR, SHOW_CURSOR = "\x1b[?25l", "\x1b[?25h"


def test_reach_is_symmetric(machine: Machine) -> None:
    """Without tilt, all-left and all-right are mirror images but for the platform's own asymmetry in x."""
    left, right = (usable_reach(machine, MODES.index(mode), 100.0) for mode in ("LLL", "RRR"))
    assert left.z_m == right.z_m
    assert left.area_m2 == pytest.approx(right.area_m2, rel=0.1)
    assert left.y_m is not None
    assert left.y_m[0] < 0.3 < left.y_m[1]


def test_no_reach(machine: Machine) -> None:
    """A machine that can be nowhere has an empty reach."""
    reach = usable_reach(machine, 0, 1.0)
    assert (reach.x_m, reach.y_m, reach.z_m, reach.area_m2) == (None, None, None, 0.0)
