"""The least distance between the surfaces of pairs of bodies, which kinds of limit have in common."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Self

import numpy as np

from pipeline.arrays import BoolArray, FloatArray, IntArray
from pipeline.limits.axis_distance import PROOF_SLACK_M
from pipeline.limits.interface.limit import Curve, Wording
from pipeline.limits.interface.proof import CertificateKey, ProvenQuantity
from pipeline.machine.bodies.distances import are_clear, body_distances, least_distances
from pipeline.machine.samples import PoseSamples
from pipeline.machine.shapes.model import Bodies

if TYPE_CHECKING:
    from pipeline.inclusion.proven_box import ProvenBox
    from pipeline.limits.interface.rows import Nodes, ProgramPart

_KEY = "machine.clearance.bodies_m"
REACH_M = 0.15
"""Larger distances count as this, so that those of most pairs need not be computed: farther than a move goes."""
_SHOWN = 3
"""Pairs named at a pose that is refused."""


@dataclass(frozen=True, eq=False)
class SurfaceDistance:
    """The surfaces of all pairs of bodies are at least so far apart.

    Attributes
    ----------
    bodies : Bodies
        The bodies and their pairs.
    proven : CertificateKey
        Where proven distances are stated.
    name : str
        What is limited: "body distance".
    subject : str
        What comes too close: "bodies".
    """

    bodies: Bodies
    proven: CertificateKey
    name: str
    subject: str
    cost: int = 7
    rounding: float = 1e-9
    slack: float = 0.0005
    near: float = 0.03
    proven_under_error: bool = True

    @property
    def least(self) -> float:
        """Least distance in metres."""
        return self.bodies.clearance_m

    @property
    def wording(self) -> Wording:
        """How the limit is named in messages."""
        return Wording(
            name=self.name,
            key=_KEY,
            rejected_move=f"{self.subject} come too close",
            refused_points=f"have {self.subject} closer than {_KEY} ({self.least:g})",
            broken_path=f"{self.subject} too close, metres",
            path_advice="Raise refine.clearance_margin_m or refine.nodes.",
            proof_advice="Raise refine.clearance_margin_m.",
        )

    @property
    def requirement(self) -> str:
        """What it asks for, in a few words."""
        return f"{self.subject} {self.least:g} m apart"

    def values(self, samples: PoseSamples) -> FloatArray:
        """Compute the distances of all pairs, at most `REACH_M` above the least one, shape (n, pairs)."""
        return body_distances(self.bodies, samples, self.least + REACH_M)

    def only(self, columns: IntArray) -> Self:
        """Limit some of the pairs alone, given by their numbers (k,)."""
        return replace(self, bodies=self.bodies.only(columns))

    def margins(self, samples: PoseSamples) -> FloatArray:
        """Compute distances less the least one, shape (n, pairs)."""
        return self.values(samples) - self.least

    def admits(self, samples: PoseSamples) -> BoolArray:
        """Tell which poses keep all pairs apart, shape (n,)."""
        return are_clear(self.bodies, samples)

    def excess(self, samples: PoseSamples) -> FloatArray:
        """By how many metres each pair is too close, shape (n, pairs)."""
        return self.least - self.values(samples)

    def violations(self, samples: PoseSamples) -> list[str]:
        """State the pairs that are too close, the worst first."""
        distances = self.values(samples)[0]
        order = np.argsort(distances, kind="stable")
        broken = [k for k in order.tolist() if distances[k] < self.least]
        more = f" ({len(broken) - _SHOWN} more pairs are too close)" if len(broken) > _SHOWN else ""
        found = [
            f"has {apart_words(self.bodies.names[k], float(distances[k]))}; {_KEY} asks for {self.least:g} m"
            for k in broken[:_SHOWN]
        ]
        if found:
            found[-1] += f"{more}; {_advice(float(distances.min()))}"
        return found

    def curves(self, samples: PoseSamples) -> Sequence[Curve]:
        """Return the least distance at each sample."""
        values = least_distances(self.bodies, samples)
        return (Curve(f"least {self.wording.name}", "m", values, self.least, np.inf),)

    def readings(self, samples: PoseSamples) -> Sequence[Curve]:
        """Return the least distance, named by the pair that is nearest at the first pose."""
        values = body_distances(self.bodies, samples)
        pair = self.bodies.names[int(values[0].argmin())]
        return (Curve(f"{self.wording.name} ({pair})", "m", values.min(axis=1), self.least, np.inf),)

    def node_margin(self, clearance_margin_m: float) -> float:
        """Return what nodes keep on top: refine.clearance_margin_m."""
        return clearance_margin_m

    def program_part(self, nodes: "Nodes") -> "ProgramPart":
        """Write the separating rows of all pairs that come near."""
        from pipeline.limits.program_rows.bodies import separation_part

        return separation_part(self.wording.name, self.bodies, self.values(nodes.guess), nodes)

    @property
    def quantities(self) -> tuple[ProvenQuantity, ...]:
        """The distances of all pairs."""
        return tuple(ProvenQuantity(self.proven, name, (self.least, np.inf)) for name in self.bodies.names)

    def bound(self, box: "ProvenBox") -> FloatArray:
        """Bound the distances of all pairs over a proven box from below, shape (pairs, 2)."""
        return self._bound(box, np.inf)

    def _bound(self, box: "ProvenBox", enough_m: float) -> FloatArray:
        from pipeline.inclusion.distances.bodies import body_distance_bounds

        least = np.maximum(body_distance_bounds(box, self.bodies, enough_m) - PROOF_SLACK_M, 0.0)
        return np.column_stack([least, np.full(len(least), np.inf)])

    def rough_bound(self, box: "ProvenBox") -> FloatArray:
        """Bound the distances of all pairs, those of pairs that are far apart by boxes around them."""
        return self._bound(box, self.least + 2.0 * PROOF_SLACK_M)

    def unproven(self, bounds: FloatArray) -> str:
        """State the pair that is not proven far enough apart."""
        short = bounds[:, 0] - self.least
        if not len(short) or short.min() >= 0.0:
            return ""
        worst = int(short.argmin())
        name = self.bodies.names[worst]
        return f"{name} are not proven {self.least:g} m apart (at least {bounds[worst, 0]:.6g} m)"


def _advice(distance_m: float) -> str:
    """Say what makes room for bodies so far apart: a smaller clearance only if they do not overlap.

    How much smaller is not said: which pairs touch by construction changes with it.
    """
    smaller = f", or lower {_KEY}" if distance_m >= 0.0 else ""
    return f"move the pose, or one of these bodies, or make it smaller{smaller}"


def apart_words(pair: str, distance_m: float) -> str:
    """Say how far apart two bodies are; those that overlap have a distance below zero."""
    if distance_m < 0.0:
        return f"{pair} overlapping by {-distance_m:.4f} m or more"
    return f"{pair} {distance_m:.4f} m apart"
