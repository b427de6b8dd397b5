"""What a limit is: a property that every pose of a motion has to keep, and the questions asked of it.

A limit states its *margins* at poses: zero at the limit, negative beyond it. **Equality is admitted**: a pose whose
margin is exactly zero is usable. This is the one rule for a usable pose; regions, start and goal, moves, paths and the
workspace all apply it (`admitted`).

Not every limit answers every question: each question has a protocol of its own.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Protocol, Self, runtime_checkable

import numpy as np

from pipeline.arrays import BoolArray, FloatArray, IntArray
from pipeline.limits.interface.proof import ProvenQuantity
from pipeline.machine.samples import PoseSamples

if TYPE_CHECKING:
    from pipeline.inclusion.proven_box import ProvenBox
    from pipeline.limits.interface.rows import Nodes, ProgramPart


@dataclass(frozen=True)
class Wording:
    """How a limit is named in messages.

    Attributes
    ----------
    name : str
        The limited quantity: "link-link distance".
    key : str
        The configuration key of the limit.
    rejected_move : str
        Why a move is rejected: "two links come too close to each other".
    refused_points : str
        Predicate about grid points that break the limit: "have links closer than ...".
    broken_path : str
        What a path breaks between its nodes, with the unit of the amount: "links too close, metres".
    path_advice, proof_advice : str
        What to change if a path breaks the limit, or cannot be proven to keep it.
    raise_key : str
        A key that, raised, admits more moves; empty for what the machine itself sets.
    """

    name: str
    key: str
    rejected_move: str
    refused_points: str
    broken_path: str
    path_advice: str
    proof_advice: str
    raise_key: str = ""


class Limit(Protocol):
    """A property that every pose has to keep, independent of how the pose is reached."""

    @property
    def wording(self) -> Wording:
        """How the limit is named in messages."""

    @property
    def requirement(self) -> str:
        """What it asks for, in a few words: "links 0.03 m apart"."""

    @property
    def cost(self) -> int:
        """Rank among the limits of a pose: cheap ones are checked first."""

    @property
    def rounding(self) -> float:
        """How far below zero a margin along a path still counts as rounding."""

    def margins(self, samples: PoseSamples) -> FloatArray:
        """Compute margins at n poses, negative beyond the limit, shape (n, m)."""

    def excess(self, samples: PoseSamples) -> FloatArray:
        """By how much each pose is beyond the limit, in the unit of the limited quantity, as the margins: (n, m)."""

    def violations(self, samples: PoseSamples) -> list[str]:
        """State in words what a single pose (n = 1) breaks; empty if it keeps the limit."""


@dataclass(frozen=True, eq=False)
class Curve:
    """A limited quantity along samples, for figures and tables; a side without a limit is infinite.

    Attributes
    ----------
    name, unit : str
        What it is.
    values : (n,)
        The value nearest to the limit at each sample.
    least, largest : float
        The limits.
    """

    name: str
    unit: str
    values: FloatArray
    least: float
    largest: float

    @property
    def allowed(self) -> str:
        """The limits in signs."""
        if np.isinf(self.least):
            return f"<= {self.largest:g}"
        return f">= {self.least:g}" if np.isinf(self.largest) else f"{self.least:g} to {self.largest:g}"


@runtime_checkable
class ShownLimit(Protocol):
    """A limit that tables and figures show along samples."""

    def curves(self, samples: PoseSamples) -> Sequence[Curve]:
        """The limited quantities at n poses."""


@runtime_checkable
class ScreeningLimit(Protocol):
    """A limit that tells which of many poses keep it at less cost than by its margins."""

    def admits(self, samples: PoseSamples) -> BoolArray:
        """Tell which of n poses keep the limit, equality included. Shape (n,)."""


@runtime_checkable
class NodeLimit(Protocol):
    """A limit that both programs of stage two keep at their nodes."""

    @property
    def slack(self) -> float:
        """How far the sequential programs may exceed the limit before their last iterate."""

    @property
    def near(self) -> float:
        """How far above its least a value is left out of a step of the sequential programs."""

    def values(self, samples: PoseSamples) -> FloatArray:
        """Compute the limited values at n poses, to be at least `least`, shape (n, m)."""

    @property
    def least(self) -> float:
        """Least allowed value."""

    def node_margin(self, clearance_margin_m: float) -> float:
        """What nodes keep on top of the limit, for `refine.clearance_margin_m`."""

    def program_part(self, nodes: "Nodes") -> "ProgramPart":
        """Write the rows, and unknowns of its own, of the nonlinear program."""


@runtime_checkable
class DivisibleLimit(NodeLimit, Protocol):
    """A limit of many values, few of which count at a time, and that are computed apart from the others."""

    def only(self, columns: IntArray) -> Self:
        """Limit some of the values alone, given by their columns (k,)."""


@runtime_checkable
class ProvenLimit(Limit, Protocol):
    """A limit that the certificate bounds over every box."""

    @property
    def quantities(self) -> tuple[ProvenQuantity, ...]:
        """The bounded quantities, m of them."""

    def bound(self, box: "ProvenBox") -> FloatArray:
        """Bound every quantity over a proven box from below and above, infinite on a side without a bound.

        In the units of their certificate keys; shape (m, 2). Bounds of several boxes are combined by taking the least
        lower and the largest upper ones.
        """

    def unproven(self, bounds: FloatArray) -> str:
        """State which bound (m, 2) does not keep the limit; empty if all do."""


@runtime_checkable
class ErrorProvenLimit(ProvenLimit, Protocol):
    """A limit whose bounds hold for every error of the actuators that a box is proven for."""

    @property
    def proven_under_error(self) -> bool:
        """True."""


@runtime_checkable
class RoughlyProvenLimit(ErrorProvenLimit, Protocol):
    """A limit of many values, most of which are far from it, where bounds need not be sharp."""

    def only(self, columns: IntArray) -> Self:
        """Limit some of the values alone, given by their columns (k,)."""

    def rough_bound(self, box: "ProvenBox") -> FloatArray:
        """Bound every quantity as `bound` does, no more sharply than shows that it keeps the limit."""


def admits(limit: Limit, samples: PoseSamples) -> BoolArray:
    """Return which poses keep a limit, equality included. Shape (n,)."""
    if isinstance(limit, ScreeningLimit):
        return limit.admits(samples)
    return np.asarray((limit.margins(samples) >= 0.0).all(axis=1), dtype=bool)


def admitted(limits: Iterable[Limit], samples: PoseSamples) -> tuple[IntArray, PoseSamples]:
    """Keep the poses that are within all limits; a pose that breaks one is not evaluated for the next.

    Returns
    -------
    rows : (k,)
        Which of the n poses are kept, ascending.
    samples : PoseSamples
        Those poses, with everything that was computed for them.
    """
    rows: IntArray = np.arange(len(samples))
    for limit in limits:
        keep = admits(limit, samples)
        if not keep.all():
            rows, samples = rows[keep], samples.take(keep)
    return rows, samples
