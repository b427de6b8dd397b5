"""What a machine can use without tilt."""

from dataclasses import replace

import pytest

from pipeline.machine import MODES, Machine
from pipeline.workspace.reach import STEP_M, reach_step, usable_reach

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


def test_a_large_machine_takes_no_longer(machine: Machine) -> None:
    """Its grid is as coarse as it is large; that of the reference machine is the default."""
    large = replace(machine, rails_m=machine.rails_m * 20.0, lengths_m=machine.lengths_m * 15.0)
    assert reach_step(machine) == STEP_M
    assert STEP_M < reach_step(large) < 1.0
    assert usable_reach(large, 0, 100.0, reach_step(large)).area_m2 >= 0.0
