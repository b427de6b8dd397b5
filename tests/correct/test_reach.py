"""By how much planned poses miss the changes of mode of another machine."""

from dataclasses import replace

import numpy as np
import pytest

from pipeline.correct import reach_gaps
from pipeline.machine import Machine
from pipeline.machine.geometry import PRIMARY, platform_arms
from pipeline.machine.rails import rail_origins
from pipeline.refine.result import Path
from tests.rails import off_x

S = np.linspace(0.0, 1.0, 2_001)


def test_the_planned_machine_misses_none(planned: Path, machine: Machine) -> None:
    """A planned path passes every change of mode at the boundary of the arm's reach."""
    gaps = reach_gaps(planned, machine, S, planned.pose(S))
    assert [gap.arm for gap in gaps] == [2, 1, 3]
    assert np.array([gap.gap_m for gap in gaps]) == pytest.approx(0.0, abs=1e-6)


@pytest.mark.parametrize("longer_m", [2e-4, -2e-4])
def test_a_link_of_another_length_misses_by_the_difference(planned: Path, machine: Machine, longer_m: float) -> None:
    """With a longer first link poses stay inside its reach by as much; with a shorter one they are beyond it."""
    lengths = machine.lengths_m.copy()
    lengths[0] += longer_m
    gaps = reach_gaps(planned, replace(machine, lengths_m=lengths), S, planned.pose(S))
    by_arm = {gap.arm: gap.gap_m for gap in gaps}
    assert by_arm == pytest.approx({1: longer_m, 2: 0.0, 3: 0.0}, abs=1e-6)


def test_rails_off_x_are_as_far_away_as_they_are(planned: Path, machine: Machine) -> None:
    """The distance of a joint from its rail is the one across that rail, wherever along it the joint is."""
    skewed = off_x(machine, largest=0.005)
    pose = planned.pose(S)
    joints = (pose[:, None, :3] + platform_arms(skewed, pose))[:, PRIMARY] - skewed.cart_offsets_m[PRIMARY]
    far = np.linalg.norm(np.cross(joints - rail_origins(skewed), skewed.rail_directions), axis=2)
    for gap in reach_gaps(planned, skewed, S, pose):
        arm, row = gap.arm - 1, int(np.argmin(np.abs(S - gap.s)))
        assert gap.gap_m == pytest.approx(skewed.lengths_m[PRIMARY[arm]] - far[row, arm], abs=1e-9)
        assert abs(gap.gap_m) > 1e-5
