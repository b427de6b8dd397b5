"""The smooth kappa of all collocation nodes, with its derivatives, as a function of CasADi.

kappa depends on H alone: its gradient by pose and carts is the one by H contracted with dH, and its second derivatives
are those by H along dH plus the gradient contracted with the second derivatives of H. CasADi derives those of H, which
are short; differentiating kappa itself twice would take it ten times as long as everything else.
"""

from collections.abc import Sequence

import casadi as ca
import numpy as np

from pipeline.arrays import FloatArray
from pipeline.machine.geometry import Machine
from pipeline.machine.schatten import smooth_condition
from pipeline.machine.symbolic import statics_function, statics_terms_function

UNKNOWNS = 9
"""Size of what H depends on: the pose (6) and the carts (3), not the telescopes."""


class NodeKappa(ca.Callback):
    """(pose and carts of k nodes (9, k)) -> kappa (1, k), gradients (9, k), second derivatives (9, 9 k).

    IPOPT evaluates objective, constraints and their derivatives at the same point one after the other: the last result
    is kept.
    """

    def __init__(self, machine: Machine, nodes: int, exponent: float) -> None:
        ca.Callback.__init__(self)
        self._nodes, self._exponent = nodes, exponent
        self._statics = statics_function(machine).map(nodes)
        self._terms = statics_terms_function(machine).map(nodes)
        self._at: FloatArray = np.full((UNKNOWNS, nodes), np.nan)
        self._result: list[ca.DM] = []
        self.construct("node_kappa", {})

    def get_n_in(self) -> int:
        """Return the number of inputs: the nodes."""
        return 1

    def get_n_out(self) -> int:
        """Return the number of outputs: values, gradients, second derivatives."""
        return 3

    def get_sparsity_in(self, i: int) -> ca.Sparsity:
        """Return a dense pattern, (9, k)."""
        return ca.Sparsity.dense(UNKNOWNS, self._nodes)

    def get_sparsity_out(self, i: int) -> ca.Sparsity:
        """Return dense patterns: (1, k), (9, k), (9, 9 k)."""
        rows, columns = ((1, 1), (UNKNOWNS, 1), (UNKNOWNS, UNKNOWNS))[i]
        return ca.Sparsity.dense(rows, columns * self._nodes)

    def eval(self, arguments: Sequence[ca.DM]) -> list[ca.DM]:
        """Evaluate at nodes (9, k); all NaN if a node is not finite."""
        at = np.array(arguments[0])
        if not np.array_equal(at, self._at):
            self._at, self._result = at, self._evaluate(at)
        return self._result

    def _evaluate(self, at: FloatArray) -> list[ca.DM]:
        k, pose, q = self._nodes, at[:6], np.vstack([at[6:], np.zeros((2, self._nodes))])
        # CasADi stores by columns: the entries of a matrix come back transposed.
        H = np.array(self._statics(pose, q)).T.reshape(k, 6, 6).transpose(0, 2, 1)
        if not np.isfinite(H).all():
            return [ca.DM(np.full(self.size_out(i), np.nan)) for i in range(3)]
        spectrum = smooth_condition(H, self._exponent)
        by_entry = spectrum.gradient.transpose(0, 2, 1).reshape(k, 36)
        terms = self._terms(at, by_entry.T)
        slopes = np.array(terms[0]).T.reshape(k, UNKNOWNS, 6, 6).transpose(0, 1, 3, 2)
        gradient = np.einsum("kij,knij->nk", spectrum.gradient, slopes, optimize=True)
        bend = np.array(terms[1]).T.reshape(k, UNKNOWNS, UNKNOWNS) + spectrum.curvature(slopes)
        return [ca.DM(spectrum.kappa[None]), ca.DM(gradient), ca.DM(bend.reshape(-1, UNKNOWNS).T)]
