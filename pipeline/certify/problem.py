"""A path to be proven, in exact arithmetic, and the proof of a single box of it."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from pipeline.arrays import FloatArray
from pipeline.certify.guess import guess_box, point_box
from pipeline.certify.reasons import NO_INCLUSION, NO_POSE, Reason
from pipeline.errors import ForwardKinematicsError
from pipeline.inclusion.closure import Geometry, geometry
from pipeline.inclusion.krawczyk import Box, Inclusion, Piecewise, along, include
from pipeline.inclusion.pieces import Piece, pieces
from pipeline.inclusion.uncertainty import CERTAIN, Uncertainty
from pipeline.machine.geometry import ACTUATORS, Machine
from pipeline.refine.result import Path

if TYPE_CHECKING:
    from pipeline.certify.result import ProvenChain

Interval = tuple[float, float, float]
"""The beginning of a piece of the splines, and an interval of s on it."""
_MOST_KEPT = 8_000
"""Boxes that are kept for other errors: some hundred MB."""


@dataclass(eq=False)
class Memory:
    """What attempts with other errors have shown; searches for tolerances use it, single proofs need none.

    Attributes
    ----------
    guesses : dict
        Boxes and the closures along them, which depend on no error; None where the links cannot close.
    failed : dict
        The least error of one kind for which a box, or what is asked of it, failed, and why.
    proven : dict
        The largest error of that kind for which a box was proven, and its link of the chain; at a single s, None.
    widening : float
        How many times as large the image of the last box was as without its hull.
    """

    guesses: dict[Interval, tuple[Box, Piecewise] | None] = field(default_factory=dict)
    failed: dict[Interval, tuple[float, Reason]] = field(default_factory=dict)
    proven: dict[Interval, tuple[float, Any]] = field(default_factory=dict)
    widening: float = 1.0

    def of_another_kind(self) -> "Memory":
        """Forget which boxes failed, and which were proven."""
        return Memory(self.guesses)


@dataclass(frozen=True, eq=False)
class ProofProblem:
    """A path to be proven.

    Attributes
    ----------
    machine : Machine
        The machine.
    path : Path
        The path; its poses are guesses of where to place boxes.
    balls : Geometry
        The machine in balls.
    pieces : tuple of Piece
        The actuators along the path, as exact polynomials.
    least_width : float
        Intervals of s that are narrower are not halved.
    uncertainty : Uncertainty
        How far the machine may be from its configuration.
    memory : Memory or None
        What attempts with other errors have shown.
    profile_m : mapping or None
        Errors of all actuators by the beginning of each piece, in place of those of the uncertainty.
    verifies : callable or None
        Says whether other arithmetic verifies a chain: searches go on until it does. None: that is not asked.
    """

    machine: Machine
    path: Path
    balls: Geometry
    pieces: tuple[Piece, ...]
    least_width: float
    uncertainty: Uncertainty
    memory: Memory | None = None
    profile_m: Mapping[float, float] | None = None
    verifies: "Callable[[ProvenChain], bool] | None" = None

    def errors_over(self, piece: Piece, s: float | None = None) -> Uncertainty:
        """Give the errors over a piece, or at a single s of it: where it meets another one, the smaller of both."""
        if self.profile_m is None:
            return self.uncertainty
        meeting = [one for one in self.pieces if s is not None and s in (one.first, one.last)]
        errors = [self.profile_m[one.first] for one in (piece, *meeting)]
        return replace(self.uncertainty, actuator_m=(min(errors),) * len(ACTUATORS))


def guess(problem: ProofProblem, piece: Piece, first: float, last: float) -> tuple[Box, Piecewise] | None:
    """Place a box over an interval of a piece, or at a single s, and evaluate the closures along it.

    None if there are no poses there.
    """
    memory, key = problem.memory, (piece.first, first, last)
    if memory is not None and key in memory.guesses:
        return memory.guesses[key]
    box = _point(problem, first) if first == last else guess_box(problem.path, first, last)
    found = None if box is None else (box, along(problem.balls, piece, box))
    if memory is not None and len(memory.guesses) < _MOST_KEPT:
        memory.guesses[key] = found
    return found


def _point(problem: ProofProblem, s: float) -> Box | None:
    try:
        return point_box(s, problem.path.pose(s))
    except ForwardKinematicsError:
        return None


def prove_box(
    problem: ProofProblem, piece: Piece, interval: tuple[float, float], likely: FloatArray | None = None
) -> tuple[Piecewise, Inclusion] | Reason:
    """Prove a box over an interval of a piece, or at a single s.

    With a memory its radii are at least as large as those (6,) given, or likely so at a single s.
    """
    first, last = interval
    if (guessed := guess(problem, piece, first, last)) is None:
        return NO_POSE
    (box, series), errors = guessed, problem.errors_over(piece, first if first == last else None)
    memory = problem.memory or Memory()
    if problem.memory is not None and likely is not None and errors.any:
        box = replace(box, radius=np.maximum(box.radius, likely))
    if (inclusion := include(problem.balls, series, box, errors, widening=memory.widening)) is None:
        return NO_INCLUSION
    memory.widening = inclusion.widening
    return series, inclusion


def build_problem(machine: Machine, path: Path, least_width: float, uncertainty: Uncertainty = CERTAIN) -> ProofProblem:
    """Turn machine and splines into exact numbers."""
    return ProofProblem(machine, path, geometry(machine), tuple(pieces(path.spline)), least_width, uncertainty)
