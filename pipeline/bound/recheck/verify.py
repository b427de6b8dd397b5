"""The proof of a bound, verified from its tree: components by faces, and every box of the wall by other code."""

from dataclasses import dataclass

import numpy as np
from scipy.sparse import csr_array
from scipy.sparse.csgraph import connected_components

from pipeline.arrays import BoolArray, FloatArray, IntArray
from pipeline.bound.bound import build_evaluator
from pipeline.bound.boxes import CELLS
from pipeline.bound.chart import Chart, chart_point
from pipeline.bound.recheck.boxes import Claim, verified
from pipeline.bound.tree import EXCLUDED, OPEN, Tree, read_tree, touching
from pipeline.certify.recheck.arithmetic.determinant import det_signs
from pipeline.config import Config
from pipeline.machine.geometry import Machine
from pipeline.machine.statics import statics_matrix
from pipeline.route.regions.endpoints import Endpoint

_NEAR = 1e-7


@dataclass(frozen=True)
class Verification:
    """What was verified of a proof.

    Attributes
    ----------
    separated : bool
        No component of open leaves holds both start and goal.
    wall : int
        Boxes that have to hold no pose.
    refuted : int
        Of those, how many were not verified.
    """

    separated: bool
    wall: int
    refuted: int

    @property
    def holds(self) -> bool:
        """Whether the bound is verified."""
        return self.separated and self.refuted == 0


def verify_bound(
    config: Config, machine: Machine, ends: tuple[Endpoint, Endpoint], kappa: float, codes: IntArray
) -> Verification:
    """Verify that every path has kappa > K, from a tree's codes.

    Raises
    ------
    ValueError
        If the codes are not those of a tree.
    NoSolutionError
        If the machine has no chart.
    """
    chart = build_evaluator(config, machine, ends, kappa).chart
    tree = read_tree(codes, chart.free)
    start, goal = (_holding(chart, tree, chart_point(chart, end)) for end in ends)
    opened = tree.codes == OPEN
    a, b = touching(tree, opened, opened)
    edge = np.flatnonzero(opened & tree.at_edge)
    a, b = np.concatenate([a, edge[:-1]]), np.concatenate([b, edge[1:]])
    n = len(codes)
    labels = connected_components(csr_array((np.ones(len(a), dtype=np.int8), (a, b)), shape=(n, n)), directed=False)[1]
    reached = np.unique(labels[start & opened])
    component = opened & np.isin(labels, reached)
    wall = np.zeros(n, dtype=bool)
    excluded = tree.codes == EXCLUDED
    wall[touching(tree, component, excluded)[1]] = True
    if (component & tree.at_edge).any():
        wall |= excluded & tree.at_edge
    wall |= excluded & start
    nodes = np.flatnonzero(wall)
    H = statics_matrix(machine, ends[0].pose[None], ends[0].q_m[None, :3])
    sign = float(det_signs(H.transpose(1, 2, 0))[0])
    good = verified(Claim(machine, sign, kappa), *_bounds(chart, tree, nodes))
    # An end that no box holds would be apart from everything.
    separated = bool(start.any() and goal.any()) and not (component & goal).any()
    return Verification(separated, len(nodes), int((~good).sum()))


def _bounds(chart: Chart, tree: Tree, nodes: IntArray | slice) -> tuple[FloatArray, FloatArray]:
    scale = ((chart.high - chart.low) / CELLS)[:, None]
    low = chart.low[:, None]
    return low + scale * tree.low[:, nodes], low + scale * tree.high[:, nodes]


def _holding(chart: Chart, tree: Tree, point: FloatArray) -> BoolArray:
    """Leaves that hold a point, or are nearer than any rounding."""
    low, high = _bounds(chart, tree, slice(None))
    near = ((low <= point[:, None] + _NEAR) & (high >= point[:, None] - _NEAR)).all(axis=0)
    return np.asarray(near & (tree.codes >= OPEN))
