"""What iterates have to keep, and how it changes with a step."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest

from pipeline.arrays import IntArray
from pipeline.config import Config
from pipeline.limits import node_limits
from pipeline.limits.axis_distance import AxisDistance
from pipeline.machine import Machine, link_distances
from pipeline.machine.working_modes import reach_along_rails
from pipeline.refine.peak.constraints import Constraint, LeastValues, least_values, pose_constraints
from pipeline.refine.peak.iterate import Iterate, iterate_at
from pipeline.refine.peak.problem import PeakProblem

H = 1e-6


@pytest.fixture(scope="module")
def guarded(peak: PeakProblem, quick_config: Config, machine: Machine) -> PeakProblem:
    """Require a distance to rails, too, sides at some points, and a direction at the start."""
    _, rail, *_ = node_limits(quick_config, replace(machine, link_rail_m=0.3))
    sides = np.zeros_like(peak.required.corridor.sides)
    sides[3, 0], sides[-4, 2] = -1.0, 1.0
    directions = peak.directions.copy()
    directions[0] = np.array([0.6, 0.0, 0.8, 0.0, 0.0])
    required = replace(
        peak.required,
        corridor=replace(peak.required.corridor, sides=sides),
        limits=[*peak.required.limits, LeastValues(rail, np.full((len(peak.points.s), 12), 0.3))],
    )
    return replace(peak, required=required, directions=directions)


def test_slopes_of_all_constraints_agree_with_differences(
    guarded: PeakProblem, iterate: Iterate, direction: np.ndarray
) -> None:
    """Every row of every constraint, along a random change of the coefficients and the length that follows."""
    ahead, behind = (
        iterate_at(guarded.points, iterate.coefficients + step * direction, iterate.samples.pose) for step in (H, -H)
    )
    assert ahead is not None
    assert behind is not None
    longer = (ahead.distances.sum() - behind.distances.sum()) / (2.0 * H)
    step = np.concatenate([direction.ravel(), [0.0, longer]])
    together: Iterator[tuple[Constraint, Constraint, Constraint]] = zip(
        guarded.constraints(iterate), guarded.constraints(ahead), guarded.constraints(behind), strict=True
    )
    count = 0
    for constraint, there, back in together:
        count += 1
        found = constraint.slope(np.arange(len(constraint.value))) @ step
        if constraint.high[0] == constraint.low[0] == constraint.value[0] == 0.0:
            # The length is what it is: its row says how it changes.
            np.testing.assert_allclose(found, 0.0, atol=1e-6 * abs(longer))
            continue
        expected = (there.value - back.value) / (2.0 * H)
        # The mean speed beside an end, and where the closest points change, are taken as they are.
        close = np.isclose(found, expected, atol=2e-4 * np.abs(expected).max() + 1e-9)
        assert np.mean(close) > 0.99
    assert count >= 9


def test_links_and_sides_are_those_of_the_machine(guarded: PeakProblem, iterate: Iterate) -> None:
    """Values are distances and reaches of the poses between the ends."""
    constraints, machine, samples = list(guarded.constraints(iterate)), guarded.points.machine, iterate.samples
    distances = link_distances(machine, samples.pose, samples.q_m[:, :3])[1:-1]
    np.testing.assert_allclose(constraints[1].value, distances.ravel())
    reach = reach_along_rails(machine, samples.pose, samples.q_m[:, :3])
    np.testing.assert_allclose(constraints[4].value, [-reach[3, 0], reach[-4, 2]])


@pytest.mark.parametrize(("value", "excess"), [(0.5, 0.0), (1.5, 5.0), (-0.2, 2.0)])
def test_excess_counts_in_units_of_the_slack(value: float, excess: float) -> None:
    """Zero within the bounds, and outside the distance to them."""
    constraint = Constraint(np.array([value]), np.zeros(1), np.ones(1), 0.1, lambda rows: rows)
    assert constraint.excess == pytest.approx(excess)


def test_a_pair_without_margin_at_the_ends_keeps_it_where_it_has_it(peak: PeakProblem) -> None:
    """The first pair is within the margin at the start; the second is not, and gets the whole margin everywhere."""
    distance = np.array([[0.0305, 0.05], [0.0308, 0.0304], [0.04, 0.05]])
    limit = peak.required.limits[0].limit
    assert limit.least == 0.03
    every = np.ones((3, 1), dtype=bool)
    wanted = least_values(limit, distance, 0.001, every).least
    np.testing.assert_allclose(wanted, [[0.0305, 0.031], [0.0308, 0.031], [0.031, 0.031]])
    # What does not count may be anything.
    counts = np.array([[True, False], [True, True], [False, True]])
    wanted = least_values(limit, distance, 0.001, counts).least
    np.testing.assert_array_equal(np.isinf(wanted), ~counts)


class _Divisible(AxisDistance):
    """Distances of which some are computed apart from the others."""

    def only(self, columns: IntArray) -> AxisDistance:
        return replace(self, distances_m=lambda samples: self.distances_m(samples)[:, columns])


def test_values_computed_apart_have_the_slopes_of_all(guarded: PeakProblem, iterate: Iterate) -> None:
    """A limit of many values is differentiated where they are near, and nothing else of it."""
    required = guarded.required.limits[-1]
    assert isinstance(required.limit, AxisDistance)
    divisible = replace(required, limit=_Divisible(**vars(required.limit)))
    slopes = []
    for one in (required, divisible):
        paths = replace(guarded.required, limits=[one])
        _, constraint, *_ = pose_constraints(guarded.points, paths, iterate)
        rows = np.arange(5, len(constraint.value), 7)
        slopes.append(constraint.slope(rows).toarray())
    np.testing.assert_array_equal(slopes[1], slopes[0])
    assert slopes[0].any()
