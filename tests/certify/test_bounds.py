"""Bounds over boxes are combined to bounds over all of them."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from pipeline.certify import Certificate
from pipeline.certify.bounds import Bounds, Ranges, combine_bounds
from pipeline.certify.chain import BoxBounds, Chain, close_chain
from pipeline.certify.problem import build_problem
from pipeline.inclusion.closure import working_precision
from pipeline.limits import ProvenLimit
from pipeline.limits.interface.proof import ProvenQuantity
from pipeline.limits.kappa import KappaCap
from pipeline.limits.link_link import for_poses
from pipeline.limits.link_rail import for_poses as rails_for_poses
from pipeline.machine import Machine
from pipeline.refine import Path


def chain_with(machine: Machine, line: Path, bounds: list[BoxBounds]) -> Chain:
    """Give the first boxes of a proven chain other bounds."""
    with working_precision(64):
        chain = close_chain(build_problem(machine, line, 1e-3))
    return replace(chain, bounds=tuple(bounds), inclusions=chain.inclusions[: len(bounds)])


def kappa_bounds(kappa: float, sign: float) -> np.ndarray:
    """Bound kappa from above, and det H by its sign."""
    return np.array([[-np.inf, kappa], [sign, sign]])


def test_the_least_and_the_largest_count(machine: Machine, line: Path) -> None:
    """Of each quantity by itself; kappa_s is where kappa has its largest bound."""
    limits: list[ProvenLimit] = [KappaCap(100.0)]
    chain = chain_with(machine, line, [(kappa_bounds(kappa, 1.0),) for kappa in (10.0, 30.0, 20.0)])
    bounds = combine_bounds(limits, chain, (0.1, 0.2))
    worst = chain.inclusions[1].box
    assert (bounds.kappa, bounds.det_sign) == (30.0, 1)
    assert bounds.kappa_s == (worst.first + worst.last) / 2.0
    assert (bounds.start_miss, bounds.goal_miss) == (0.1, 0.2)


def test_a_sign_that_changes_is_none(machine: Machine, line: Path) -> None:
    """Nor is one that some box does not prove."""
    for signs in ([1.0, -1.0], [1.0, 0.0], [-1.0, 0.0]):
        chain = chain_with(machine, line, [(kappa_bounds(10.0, sign),) for sign in signs])
        assert combine_bounds([KappaCap(100.0)], chain, (0.0, 0.0)).det_sign == 0


def test_limits_with_one_key_share_its_section(machine: Machine, line: Path) -> None:
    """Distances of links and of rails stand one after the other, in the order of the limits."""
    limits = [*for_poses(machine, 100.0), *rails_for_poses(replace(machine, link_rail_m=0.01), 100.0)]
    proven = [limit for limit in limits if isinstance(limit, ProvenLimit)]
    counts = [len(limit.quantities) for limit in proven]
    values = [np.column_stack([np.full(count, float(k)), np.full(count, np.inf)]) for k, count in enumerate(counts)]
    bounds = combine_bounds(
        [KappaCap(9.0), *proven], chain_with(machine, line, [(kappa_bounds(1.0, 1.0), *values)]), (0, 0)
    )
    names: list[ProvenQuantity] = [quantity for limit in proven for quantity in limit.quantities]
    assert bounds.pairs == tuple(quantity.subject for quantity in names)
    assert bounds.distances_m.tolist() == [0.0] * counts[0] + [1.0] * counts[1]


def test_a_certificate_has_plain_figures(machine: Machine, line: Path, prove: Callable[..., Certificate]) -> None:
    """Each of its figures is the one of its key."""
    bounds = prove(machine, line).bounds
    assert isinstance(bounds, Bounds)
    assert bounds.kappa == bounds.ranges["kappa"].values[0, 1]
    assert bounds.actuators_m.shape == (5, 2)
    assert bounds.tilt_deg.shape == (2,)
    assert isinstance(bounds.ranges["distance_m"], Ranges)
