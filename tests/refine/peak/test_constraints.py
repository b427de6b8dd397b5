"""What iterates have to keep, and how it changes with a step."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest

from pipeline.machine import link_distances
from pipeline.machine.working_modes import reach_along_rails
from pipeline.refine.peak.constraints import Limit, least_distances
from pipeline.refine.peak.iterate import Iterate, iterate_at
from pipeline.refine.peak.sqp import PeakProblem

H = 1e-6
EVERYWHERE = slice(None)


def _guarded(ground: PeakProblem) -> PeakProblem:
    """Ask for rails to be kept clear of, for sides at some nodes, and for a direction at the start."""
    looks = replace(ground.looks, machine=replace(ground.looks.machine, link_rail_m=0.3))
    sides = np.zeros_like(ground.demands.corridor.sides)
    sides[3, 0], sides[-4, 2] = -1.0, 1.0
    corridor = replace(ground.demands.corridor, sides=sides)
    directions = ground.directions.copy()
    directions[0] = np.array([0.6, 0.0, 0.8, 0.0, 0.0])
    demands = replace(ground.demands, corridor=corridor, rail_m=np.full((len(looks.s), 12), 0.3))
    return replace(ground, looks=looks, demands=demands, directions=directions)


def test_slopes_of_all_limits_agree_with_differences(
    ground: PeakProblem, iterate: Iterate, direction: np.ndarray
) -> None:
    """Every row of every limit, along a random change of the coefficients and the change of length that follows."""
    ground = _guarded(ground)
    ahead, behind = (
        iterate_at(ground.looks, iterate.coefficients + step * direction, iterate.pose) for step in (H, -H)
    )
    assert ahead is not None
    assert behind is not None
    longer = (ahead.distances.sum() - behind.distances.sum()) / (2.0 * H)
    step = np.concatenate([direction.ravel(), [0.0, longer]])
    together: Iterator[tuple[Limit, Limit, Limit]] = zip(
        ground.limits(iterate), ground.limits(ahead), ground.limits(behind), strict=True
    )
    count = 0
    for limit, there, back in together:
        count += 1
        found = limit.slope(np.arange(len(limit.value))) @ step
        if limit.high[0] == limit.low[0] == limit.value[0] == 0.0:
            # The length is what it is: its row says how it changes.
            np.testing.assert_allclose(found, 0.0, atol=1e-6 * abs(longer))
            continue
        expected = (there.value - back.value) / (2.0 * H)
        # The mean speed beside an end, and where the closest points change, are taken as they are.
        close = np.isclose(found, expected, atol=2e-4 * np.abs(expected).max() + 1e-9)
        assert np.mean(close) > 0.99
    assert count >= 9


def test_links_and_sides_are_those_of_the_machine(ground: PeakProblem, iterate: Iterate) -> None:
    """Values are distances and reaches of the poses between the ends."""
    guarded = _guarded(ground)
    limits = list(guarded.limits(iterate))
    distances = link_distances(ground.looks.machine, iterate.pose, iterate.q_m[:, :3])[1:-1]
    np.testing.assert_allclose(limits[1].value, distances.ravel())
    reach = reach_along_rails(ground.looks.machine, iterate.pose, iterate.q_m[:, :3])
    np.testing.assert_allclose(limits[3].value, [-reach[3, 0], reach[-4, 2]])


@pytest.mark.parametrize(("value", "excess"), [(0.5, 0.0), (1.5, 5.0), (-0.2, 2.0)])
def test_excess_counts_in_units_of_the_slack(value: float, excess: float) -> None:
    """Nothing within the bounds, and how far beyond them else."""
    limit = Limit(np.array([value]), np.zeros(1), np.ones(1), 0.1, lambda rows: rows)
    assert limit.excess == pytest.approx(excess)


def test_a_pair_without_margin_at_the_ends_has_it_where_it_had_it() -> None:
    """The first pair is within the margin at the start; the second is not, and gets the whole margin everywhere."""
    distance = np.array([[0.0305, 0.05], [0.0308, 0.0304], [0.04, 0.05]])
    wanted = least_distances(distance, 0.03, 0.001)
    np.testing.assert_allclose(wanted, [[0.0305, 0.031], [0.0308, 0.031], [0.031, 0.031]])
