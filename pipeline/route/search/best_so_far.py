"""The best sequence of a search, while it goes on and when it has ended."""

from dataclasses import dataclass, replace

import numpy as np

from pipeline.route.bounds.shortest_paths import Bounds
from pipeline.route.core.build import Core
from pipeline.route.deadline import Deadline
from pipeline.route.metric import ROUNDING
from pipeline.route.programs.solution import StepSequence
from pipeline.route.search.states import StateGraph
from pipeline.status import Status

CLOSED = 1e-7
"""Relative distance of the bounds at which they count as met."""


@dataclass(frozen=True, eq=False)
class Optimum:
    """The best sequence found over the moves admitted so far, with what is proven of it.

    Attributes
    ----------
    sequence : StepSequence
        Rows of the region table, and x, of the steps.
    threshold : float
        T of the core it was found on; infinite for a program over all regions.
    regions : int
        Number of regions of the program.
    relaxation : float
        Bound on the cost when the step budget is left out, and x but for its price.
    bound : float
        Proven lower bound on the cost.
    proven : bool
        That it is the optimum; otherwise the time ran out.
    cap : float
        Cap on kappa: the least that leaves a route where the largest kappa counts, infinite where only the sum does.
    """

    sequence: StepSequence
    threshold: float
    regions: int
    relaxation: float
    bound: float
    proven: bool = True
    cap: float = np.inf

    @property
    def objective(self) -> float:
        """The cost, as the solver gives it."""
        return self.sequence.outcome.objective


class BestSoFar:
    """The least costly sequence found on the cores solved so far, whatever their thresholds.

    Attributes
    ----------
    excluded : float
        No route is less costly (proven).
    """

    def __init__(self, graph: StateGraph, bounds: Bounds, excluded: float) -> None:
        self.excluded = excluded
        self._graph = graph
        self._bounds = bounds
        self._found: tuple[StepSequence, Core] | None = None

    @property
    def objective(self) -> float:
        """Its cost, infinite without one."""
        return self._found[0].outcome.objective if self._found else np.inf

    @property
    def sequence(self) -> StepSequence | None:
        """The sequence itself, in rows of the graph."""
        return self._found[0] if self._found else None

    def offer(self, sequence: StepSequence | None, core: Core) -> None:
        """Take over a route that was found without a proof, if there is one and it is better."""
        if sequence is not None and len(sequence.region) and sequence.outcome.objective < self.objective:
            self._found = (sequence, core)

    def decided_by(self, sequence: StepSequence, core: Core, deadline: Deadline) -> bool:
        """Take over the outcome of a core; return whether it is the optimum.

        Raises
        ------
        OutOfTimeError
            When the time ran out before that was proven.
        """
        outcome = sequence.outcome
        # Of equal ones the last is taken, whose core may prove it.
        if len(sequence.region) and outcome.objective <= self.objective * (1.0 + ROUNDING):
            self._found = (sequence, core)
        if outcome.status not in (Status.OPTIMAL, Status.INFEASIBLE):
            self.excluded = max(self.excluded, min(outcome.bound, core.threshold))
            raise deadline.error(self.excluded)
        return outcome.objective <= core.threshold * (1.0 + ROUNDING)

    def meets(self, bound: float) -> bool:
        """Tell whether it costs no more than a lower bound."""
        return self._found is not None and self.objective <= bound + CLOSED * abs(bound)

    def proven(self, bound: float) -> Optimum:
        """Give it as the optimum."""
        assert self._found is not None
        sequence, core = self._found
        return Optimum(in_table(sequence, self._graph), core.threshold, core.regions, self._bounds.optimum, bound)

    def unproven(self, deadline: Deadline) -> Optimum:
        """Give it as what was found in time, with the bound proven by then.

        Raises
        ------
        OutOfTimeError
            When nothing was found.
        """
        if self._found is None:
            raise deadline.error(self.excluded)
        return replace(self.proven(min(self.excluded, self.objective)), proven=False)


def in_table(sequence: StepSequence, graph: StateGraph) -> StepSequence:
    """Give a sequence of the graph in rows of the region table."""
    return replace(sequence, region=graph.base[sequence.region])
