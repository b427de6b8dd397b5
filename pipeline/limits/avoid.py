"""Boxes of controlled poses that the TCP must not enter (`task.avoid`), or may be asked to visit."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from pipeline.arrays import BoolArray, FloatArray
from pipeline.config import BoxConfig, Config
from pipeline.limits.interface.limit import Curve, Limit, Wording
from pipeline.limits.interface.measure import Measure
from pipeline.limits.interface.proof import CertificateEntry, CertificateKey, ProvenQuantity, Side
from pipeline.limits.interface.relaxation import Relaxation, removals
from pipeline.machine.geometry import Machine
from pipeline.machine.samples import PoseSamples

if TYPE_CHECKING:
    from pipeline.inclusion.proven_box import ProvenBox

ROUNDING = 1e-9
PROOF_SLACK = 1e-5
"""What proven bounds are weakened by, in metres or radians, so that other arithmetic can verify them."""
PROOF_ROUNDING = 1e-6
"""By how much a box may be entered by a path that was made to touch it."""
AVOIDED_BY = CertificateKey("avoided_by", Side.FLOOR, None, "out of {}", "m or rad", 5, optional=True)


@dataclass(frozen=True, eq=False)
class Box:
    """Least and largest x, y, z, rx, rz, both (5,), in metres and radians; infinite where any value will do."""

    low: FloatArray
    high: FloatArray

    @classmethod
    def of(cls, config: BoxConfig) -> "Box":
        """Read a box."""
        sides = []
        for key in ("x_m", "y_m", "z_m", "rx_deg", "rz_deg"):
            interval = getattr(config, key) or (-np.inf, np.inf)
            sides.append(np.deg2rad(interval) if key.endswith("deg") else np.array(interval))
        low, high = np.array(sides, dtype=float).T
        return cls(low, high)

    def grown(self, by: FloatArray) -> "Box":
        """Return the box with `by` (5,) added on every side."""
        return Box(self.low - by, self.high + by)

    def across(self) -> "Box":
        """Return the box with any x."""
        return Box(np.append(-np.inf, self.low[1:]), np.append(np.inf, self.high[1:]))

    def inside(self, controlled: FloatArray) -> BoolArray:
        """Return which controlled poses (..., 5) are inside, the surface left out."""
        deep = (controlled > self.low + ROUNDING) & (controlled < self.high - ROUNDING)
        return np.asarray(deep.all(axis=-1), dtype=bool)

    def near(self, controlled: FloatArray, steps: FloatArray) -> BoolArray:
        """Return which controlled poses (..., 5) are, at whatever x, within one of `steps` (5,) of it or inside."""
        return self.across().grown(steps * (1.0 + ROUNDING)).inside(controlled)

    def depth_m(self, controlled: FloatArray) -> FloatArray:
        """Compute the distance of controlled poses (..., 5) to the nearest side, in metres and radians; outside < 0."""
        return np.asarray(np.minimum(controlled - self.low, self.high - controlled).min(axis=-1), dtype=float)

    def depth(self, controlled: FloatArray) -> FloatArray:
        """Compute the depth of controlled poses (..., 5) as a part of the half width: 1 in the middle, outside < 0."""
        limited = np.isfinite(self.low) & np.isfinite(self.high)
        low, high = self.low[limited], self.high[limited]
        middle, half = (low + high) / 2.0, (high - low) / 2.0
        return np.asarray((1.0 - np.abs(controlled[..., limited] - middle) / half).min(axis=-1), dtype=float)


@dataclass(frozen=True, eq=False)
class AvoidedBox:
    """The TCP stays out of a box; its surface may be touched.

    Attributes
    ----------
    box : Box
        The box.
    number : int
        Its entry in `task.avoid`, from 0.
    """

    box: Box
    number: int
    cost: int = 0
    rounding: float = 1e-9
    proven_under_error: bool = True

    @property
    def key(self) -> str:
        """Configuration key of the box."""
        return f"task.avoid[{self.number}]"

    @property
    def wording(self) -> Wording:
        """How the limit is named in messages."""
        return Wording(
            name="box to avoid",
            key=self.key,
            rejected_move="the TCP enters a box to avoid",
            refused_points=f"are inside {self.key}",
            broken_path=f"{self.key} is entered, metres or radians",
            path_advice="Raise refine.clearance_margin_m or refine.nodes.",
            proof_advice="Raise refine.clearance_margin_m or refine.nodes, and refine again.",
            raise_key="route.avoid_margin",
        )

    @property
    def requirement(self) -> str:
        """What it asks for, in a few words."""
        return f"outside {self.key}"

    def margins(self, samples: PoseSamples) -> FloatArray:
        """Compute how far outside the box poses are, shape (n, 1)."""
        return -self.box.depth_m(samples.controlled)[:, None]

    def excess(self, samples: PoseSamples) -> FloatArray:
        """By how many metres or radians poses are inside, shape (n, 1)."""
        return self.box.depth_m(samples.controlled)[:, None]

    def violations(self, samples: PoseSamples) -> list[str]:
        """State that the pose is inside."""
        return [f"is inside {self.key}"] if self.box.inside(samples.controlled)[0] else []

    def readings(self, samples: PoseSamples) -> Sequence[Curve]:
        """Return how deep the TCP is inside, in half widths of the box along its nearest side: negative outside."""
        return (Curve(f"depth in {self.key}", "half widths", self.box.depth(samples.controlled), -np.inf, 0.0),)

    @property
    def quantities(self) -> tuple[ProvenQuantity, ...]:
        """How far outside the motion stays, by the side that it is farthest beyond."""
        return (ProvenQuantity(AVOIDED_BY, self.key, (0.0, np.inf)),)

    def bound(self, box: "ProvenBox") -> FloatArray:
        """Bound how far outside the poses of a proven box are from below, shape (1, 2)."""
        from pipeline.inclusion.distances.avoidance import least_outside

        return np.array([[least_outside(box, self.box.low, self.box.high) - PROOF_SLACK, np.inf]])

    def unproven(self, bounds: FloatArray) -> str:
        """State that the motion is not proven to stay outside."""
        least = float(bounds[0, 0])
        if least >= -(PROOF_ROUNDING + PROOF_SLACK):
            return ""
        return f"{self.key} is not proven to be avoided (the bound is {-least:.3g} m or rad inside)"


def boxes_to_avoid(config: Config) -> list[Box]:
    """Read `task.avoid`: the boxes as they are, for poses known exactly."""
    return [Box.of(box) for box in config.task.avoid]


def for_poses(machine: Machine, kappa_max: float) -> list[Limit]:
    """Return no limit: boxes cut the x windows of regions."""
    return []


def for_moves(config: Config, machine: Machine) -> list[Limit]:
    """Return the limits of moves between regions, for poses with an x of their own."""
    return [AvoidedBox(box, number) for number, box in enumerate(boxes_to_avoid(config))]


def for_path(config: Config, machine: Machine) -> list[Limit]:
    """Return the limits of a path."""
    return for_moves(config, machine)


def relaxations(config: Config, machine: Machine) -> list[Relaxation]:
    """Remove all boxes, and each one alone."""
    return removals(config, "avoid")


def _premises(config: Config) -> dict[str, Any]:
    """Give the boxes: nothing without any, so that certificates of such tasks stay."""
    boxes = [box.model_dump(mode="json") for box in config.task.avoid]
    return {"avoid": boxes} if boxes else {}


CERTIFICATE = CertificateEntry((AVOIDED_BY,), _premises)
MEASURES: tuple[Measure, ...] = ()
