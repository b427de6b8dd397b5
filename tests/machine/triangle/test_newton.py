"""The dependent angle ry of machines whose joint 3a is off the platform's y axis, by Newton's method."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pipeline.arrays import FloatArray
from pipeline.machine import Machine
from pipeline.machine.triangle.closure import on_axis
from pipeline.machine.triangle.newton import nearest_root
from pipeline.machine.triangle.search import mismatch, root_search

seeds = st.integers(0, 2**32 - 1)


def off_axis(machine: Machine, offset_m: float, length_m: float) -> Machine:
    """Move joint 3a off the axis, and give link 3c a length: with 1.36 m the triangle folds within reach."""
    points, lengths = machine.platform_points_m.copy(), machine.lengths_m.copy()
    points[3, [0, 2]] += 0.6 * offset_m, -0.8 * offset_m
    lengths[5] = length_m
    return replace(machine, platform_points_m=points, lengths_m=lengths)


def nearest_is_that_of_the_search(machine: Machine, controlled: FloatArray, signs: FloatArray) -> int:
    """Compare certain angles with those of the search; return how many are not certain.

    The search overlooks two roots between neighbouring samples: what it does not find has to close the triangle.
    """
    assert not on_axis(machine)
    angle, is_certain = nearest_root(machine, controlled, signs)
    searched = root_search(machine, controlled, signs)
    seen = is_certain & np.isfinite(searched)
    np.testing.assert_allclose(angle[seen], searched[seen], rtol=0.0, atol=1e-10)
    more = is_certain & np.isfinite(angle) & ~seen
    assert np.abs(mismatch(machine, angle[more], controlled[more], signs[more])).max(initial=0.0) < 1e-12
    assert np.isnan(angle[~is_certain]).all()
    return int(np.count_nonzero(~is_certain))


@given(seed=seeds, offset_m=st.sampled_from([1e-6, 1e-4, 1e-3, 0.02, 0.2]), length_m=st.sampled_from([1.2567, 1.36]))
@settings(max_examples=15)
def test_certain_angles_are_those_of_the_search(
    machine: Machine, draw_controlled: Callable, seed: int, offset_m: float, length_m: float
):
    """Whatever the offset: where an angle, or that there is none, is certain, the search over a turn agrees."""
    controlled, modes = draw_controlled(seed, 150)
    signs = np.where(modes % 2, 1.0, -1.0)
    signs[::10] = 0.0
    nearest_is_that_of_the_search(off_axis(machine, offset_m, length_m), controlled, signs)


@pytest.mark.parametrize(("offset_m", "most"), [(1e-6, 2), (1e-4, 10), (1e-3, 50)])
def test_a_calibrated_machine_is_hardly_ever_searched(
    machine: Machine, draw_controlled: Callable, offset_m: float, most: int
):
    """With offsets that a calibration finds, at most 1 in 80 poses is left to the search, which costs 80 times more."""
    controlled, modes = draw_controlled(5, 4000)
    angle, is_certain = nearest_root(off_axis(machine, offset_m, 1.2567), controlled, np.where(modes % 2, 1.0, -1.0))
    assert np.count_nonzero(~is_certain) <= most
    assert np.count_nonzero(np.isfinite(angle)) > 2000


@pytest.mark.parametrize("offset_m", [1e-5, 1e-3])
def test_beside_the_fold_and_the_limit_of_reach_nothing_is_certain(machine: Machine, offset_m: float):
    """Rows across both, a hundred per offset, change from an angle to none; in between they are left to the search."""
    folding = off_axis(machine, offset_m, 1.36)
    for y, z in ((np.linspace(0.3, 0.6, 20_001), 0.9), (0.3, np.linspace(1.1, 1.3, 20_001))):
        controlled = np.zeros((20_001, 5))
        controlled[:, 1], controlled[:, 2], controlled[:, 3:] = y, z, (0.2, -0.1)
        assert nearest_is_that_of_the_search(folding, controlled, np.full(20_001, -1.0)) > 0
