"""Least distances between axes: what link-link and link-rail distance have in common."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from pipeline.arrays import FloatArray
from pipeline.config import Config
from pipeline.limits.interface.limit import Curve, Wording
from pipeline.limits.interface.proof import CertificateKey, ProvenQuantity, Side
from pipeline.limits.interface.relaxation import Relaxation, threshold_filter, with_values
from pipeline.machine.geometry import LINKS
from pipeline.machine.samples import PoseSamples

if TYPE_CHECKING:
    from pipeline.inclusion.proven_box import ProvenBox
    from pipeline.limits.interface.rows import Nodes, ProgramPart

PROOF_SLACK_M = 5e-5
"""What proven bounds of distances are weakened by, so that other arithmetic can verify them."""
_STEP_M, _ROUNDING = 1e-4, 1e-9
DISTANCE = CertificateKey("distance_m", Side.LEAST, None, "least distance of axes", "m", 5, optional=True)
"""Of both kinds of distance."""


@dataclass(frozen=True, eq=False)
class AxisDistance:
    """The axes of all pairs are at least so far apart.

    Attributes
    ----------
    least : float
        Least distance in metres.
    pairs : list of (int, int)
        Links as indices; the second of a pair is a rail if `from_rail`.
    from_rail : bool
        Whether the pairs are of links and rails.
    distances_m : callable
        Computes the distances of all pairs at n poses, shape (n, pairs).
    wording : Wording
        How the limit is named in messages.
    cost : int
        Order of evaluation among the limits: cheap ones first.
    """

    least: float
    pairs: list[tuple[int, int]]
    from_rail: bool
    distances_m: Callable[[PoseSamples], FloatArray]
    wording: Wording
    cost: int
    rounding: float = 1e-9
    slack: float = 0.0005
    proven_under_error: bool = True
    near: float = 0.1

    @property
    def requirement(self) -> str:
        """What it asks for, in a few words."""
        return f"{'links and rails' if self.from_rail else 'links'} {self.least:g} m apart"

    def values(self, samples: PoseSamples) -> FloatArray:
        """Compute the distances of all pairs, shape (n, pairs)."""
        return self.distances_m(samples)

    def margins(self, samples: PoseSamples) -> FloatArray:
        """Compute distances less the least one, shape (n, pairs)."""
        return self.values(samples) - self.least

    def excess(self, samples: PoseSamples) -> FloatArray:
        """By how many metres each pair is too close, shape (n, pairs)."""
        return self.least - self.values(samples)

    def violations(self, samples: PoseSamples) -> list[str]:
        """State the nearest pair if it is too close."""
        nearest = float(self.values(samples).min())
        what = "a link {:.4f} m from a rail" if self.from_rail else "links {:.4f} m apart"
        return (
            []
            if nearest >= self.least
            else [f"has {what.format(nearest)}; {self.wording.key} asks for {self.least:g} m"]
        )

    def curves(self, samples: PoseSamples) -> Sequence[Curve]:
        """Return the least distance at each sample."""
        return (Curve(f"least {self.wording.name}", "m", self.values(samples).min(axis=1), self.least, np.inf),)

    def readings(self, samples: PoseSamples) -> Sequence[Curve]:
        """Return the least distance, named by the pair that is nearest at the first pose."""
        values = self.values(samples)
        pair = pair_names(self.pairs, self.from_rail)[int(values[0].argmin())]
        return (Curve(f"{self.wording.name} ({pair})", "m", values.min(axis=1), self.least, np.inf),)

    def node_margin(self, clearance_margin_m: float) -> float:
        """Return what nodes keep on top: refine.clearance_margin_m."""
        return clearance_margin_m

    def program_part(self, nodes: "Nodes") -> "ProgramPart":
        """Write the separating rows of all pairs that come near."""
        from pipeline.limits.program_rows.axis_distance import separation_part

        distances = self.values(nodes.guess)
        return separation_part(self.wording.name, self.pairs, self.from_rail, distances, self.least, nodes)

    @property
    def quantities(self) -> tuple[ProvenQuantity, ...]:
        """The distances of all pairs."""
        names = pair_names(self.pairs, self.from_rail)
        return tuple(ProvenQuantity(DISTANCE, name, (self.least, np.inf)) for name in names)

    def bound(self, box: "ProvenBox") -> FloatArray:
        """Bound the distances of all pairs over a proven box from below, shape (pairs, 2)."""
        from pipeline.inclusion.distances.axes import AxisPairs, distance_bounds

        pairs = AxisPairs.of(self.pairs, self.from_rail, box.machine)
        least = distance_bounds(pairs, box.series, box.displacement, box.erring)
        return np.column_stack([np.maximum(least - PROOF_SLACK_M, 0.0), np.full(len(least), np.inf)])

    def unproven(self, bounds: FloatArray) -> str:
        """State the pair that is not proven far enough apart."""
        short = bounds[:, 0] - self.least
        if not len(short) or short.min() >= 0.0:
            return ""
        worst = int(short.argmin())
        name = pair_names(self.pairs, self.from_rail)[worst]
        return f"{name} are not proven {self.least:g} m apart (at least {bounds[worst, 0]:.6g} m)"


def pair_names(pairs: list[tuple[int, int]], from_rail: bool) -> tuple[str, ...]:
    """Name pairs of links, or of links and rails."""
    if from_rail:
        return tuple(f"link {LINKS[link]} and rail {rail + 1}" for link, rail in pairs)
    return tuple(f"links {LINKS[a]} and {LINKS[b]}" for a, b in pairs)


def distance_relaxation(config: Config, key: str, distances_m: Callable[[PoseSamples], FloatArray]) -> list[Relaxation]:
    """Return distances below the configured `machine.clearance` key, down to zero, 0.1 mm apart."""
    configured = getattr(config.machine.clearance, key)
    count = int(np.ceil(configured / _STEP_M - _ROUNDING))
    smaller = np.asarray(_STEP_M * np.arange(count - 1, -1, -1), dtype=float).round(9)

    def change(value: float) -> Config:
        clearance = config.machine.clearance.model_copy(update={key: value})
        return with_values(config, "machine", clearance=clearance)

    return [
        Relaxation.of_one_table(
            key=f"machine.clearance.{key}",
            configured=configured,
            milder=smaller,
            change=change,
            prepare=lambda samples, windows_m: threshold_filter(
                np.asarray(distances_m(samples).min(axis=1)), windows_m, at_most=False
            ),
        )
    ]
