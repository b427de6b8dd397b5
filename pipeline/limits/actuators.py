"""Cart travel and telescope strokes.

x enters a pose through cart travel alone: without a given x, travel leaves an interval of x, the *window* of the pose.

Start, goal and poses to visit may be anywhere within travel and strokes; routes and paths keep margins from their ends
(`actuator_margins`).
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from pipeline.arrays import BoolArray, FloatArray
from pipeline.config import Config
from pipeline.limits.actuator_margins import given_poses, planned_range_m, within_margins
from pipeline.limits.interface.limit import Curve, Limit, Wording
from pipeline.limits.interface.measure import Measure
from pipeline.limits.interface.proof import CertificateEntry, CertificateKey, ProvenQuantity, Side
from pipeline.limits.interface.relaxation import RegionFilter, Relaxation, threshold_filter, with_values
from pipeline.machine.geometry import ACTUATORS, Machine
from pipeline.machine.samples import PoseSamples

if TYPE_CHECKING:
    from pipeline.inclusion.proven_box import ProvenBox

TRAVEL_KEY = "machine.rails.travel_m"
"""Key of the relaxation of cart travel; its values are what all rails are longer by at either end."""
TRAVEL_REFUSED = "need a cart beyond its rail, wherever x is"
"""Predicate about grid points without a window of x."""
PROOF_SLACK_M = 1e-5
"""What proven bounds are weakened by, so that other arithmetic can verify them."""
PROOF_ROUNDING_M = 1e-6
"""By how much a bound may pass a limit that the path was made to touch."""
_POSITIONS = CertificateKey("actuators_m", Side.BOTH, ACTUATORS, unit="m", decimals=4)
_TRAVEL_STEP_M, _TRAVEL_COUNT = 1e-3, 1_000
_MARGIN_STEP_M, _ROUNDING = 1e-4, 1e-9
_ALL, _STROKES = slice(0, 5), slice(3, 5)


@dataclass(frozen=True, eq=False)
class ActuatorRange:
    """Some of the actuators stay within their ranges.

    Attributes
    ----------
    columns : slice
        Which of c1, c2, c3, l2b, l3b.
    range_m : (m, 2)
        Least and largest position of each.
    """

    columns: slice
    range_m: FloatArray
    cost: int = 0
    rounding: float = 1e-9

    @property
    def wording(self) -> Wording:
        """How the limit is named in messages."""
        return Wording(
            name="actuator position",
            key="machine.rails.travel_m, machine.links.l2b.stroke_m, machine.links.l3b.stroke_m",
            rejected_move="an actuator leaves its range",
            refused_points="need a telescope beyond its stroke",
            broken_path="actuators beyond stroke or travel less their margins, metres",
            path_advice="Raise refine.nodes.",
            proof_advice="Raise refine.nodes, and refine again.",
        )

    @property
    def requirement(self) -> str:
        """What it asks for, in a few words."""
        return f"{', '.join(ACTUATORS[self.columns])} within their ranges"

    def margins(self, samples: PoseSamples) -> FloatArray:
        """Compute distances to both ends of every range, shape (n, 2 m)."""
        q = samples.q_m[:, self.columns]
        return np.concatenate([q - self.range_m[:, 0], self.range_m[:, 1] - q], axis=1)

    def excess(self, samples: PoseSamples) -> FloatArray:
        """By how many metres actuators are out of their ranges, shape (n, 2 m)."""
        return -self.margins(samples)

    def violations(self, samples: PoseSamples) -> list[str]:
        """State every actuator that is out of its range."""
        rows = zip(ACTUATORS[self.columns], samples.q_m[0, self.columns], self.range_m, strict=True)
        return [
            f"needs {name} at {value:.4f} m; allowed are {least:g} to {largest:g} m"
            for name, value, (least, largest) in rows
            if not least <= value <= largest
        ]

    def readings(self, samples: PoseSamples) -> Sequence[Curve]:
        """Return the position of each actuator."""
        rows = zip(ACTUATORS[self.columns], samples.q_m[:, self.columns].T, self.range_m.tolist(), strict=True)
        return tuple(Curve(name, "m", values, least, largest) for name, values, (least, largest) in rows)

    @property
    def quantities(self) -> tuple[ProvenQuantity, ...]:
        """The positions of the actuators."""
        ranges = zip(ACTUATORS[self.columns], self.range_m.tolist(), strict=True)
        return tuple(ProvenQuantity(_POSITIONS, name, (least, largest)) for name, (least, largest) in ranges)

    def bound(self, box: "ProvenBox") -> FloatArray:
        """Bound the actuators over a proven box, shape (m, 2)."""
        from pipeline.inclusion.bounds import actuator_ranges

        slack = np.array([-PROOF_SLACK_M, PROOF_SLACK_M])
        return np.asarray(actuator_ranges(box)[self.columns] + slack, dtype=float)

    def unproven(self, bounds: FloatArray) -> str:
        """State the actuator that is not proven to stay within its range."""
        excess = np.maximum(self.range_m[:, 0] - bounds[:, 0], bounds[:, 1] - self.range_m[:, 1])
        if excess.max() <= PROOF_ROUNDING_M + PROOF_SLACK_M:
            return ""
        worst = int(excess.argmax())
        name = ACTUATORS[self.columns][worst]
        return f"{name} is not proven to stay within its limits (beyond by {excess[worst]:.3g} m)"


def cart_travel(machine: Machine) -> ActuatorRange:
    """Return the limit of cart travel, for poses with an x of their own."""
    return ActuatorRange(slice(0, 3), machine.travel_m)


def x_windows(machine: Machine, q_m: FloatArray) -> FloatArray:
    """Compute [least, largest] x for which all carts are on their rails, for actuators (n, 5) at x = 0. Shape (n, 2).

    Empty windows have their least x above the largest.
    """
    carts = q_m[:, :3]
    least = (machine.travel_m[:, 0] - carts).max(axis=1)
    largest = (machine.travel_m[:, 1] - carts).min(axis=1)
    return np.column_stack([least, largest])


def for_poses(machine: Machine, kappa_max: float) -> list[Limit]:
    """Return the limit of poses without a given x: strokes alone; travel makes windows of x."""
    return [ActuatorRange(_STROKES, machine.strokes_m)]


def for_moves(config: Config, machine: Machine) -> list[Limit]:
    """Return no limit: between two ends that keep travel and strokes, a straight line keeps them, too."""
    return []


def for_path(config: Config, machine: Machine) -> list[Limit]:
    """Return the limit of a path."""
    return [ActuatorRange(_ALL, planned_range_m(config, machine))]


def relaxations(config: Config, machine: Machine) -> list[Relaxation]:
    """Return smaller margins of rails and strokes, and rails that are longer at both ends, up to a metre."""
    return [*_smaller_margins(config, machine), _longer_rails(config, machine)]


def _longer_rails(config: Config, machine: Machine) -> Relaxation:
    machine = within_margins(config, machine)
    longer = np.array([k * _TRAVEL_STEP_M for k in range(1, _TRAVEL_COUNT + 1)]).round(9)

    def change(value: float) -> Config:
        rails = []
        for rail in config.machine.rails:
            least, largest = rail.travel_m
            rails.append(rail.model_copy(update={"travel_m": (least - value, largest + value)}))
        return with_values(config, "machine", rails=tuple(rails))

    def prepare(samples: PoseSamples, windows_m: FloatArray) -> RegionFilter:
        allowed = _windows_at(machine, samples)
        return lambda value: _narrowed(windows_m, allowed + [-value, value])

    return Relaxation.of_one_table(TRAVEL_KEY, 0.0, longer, change, prepare)


def _smaller_margins(config: Config, machine: Machine) -> list[Relaxation]:
    def on_rails(samples: PoseSamples, windows_m: FloatArray) -> RegionFilter:
        allowed = _windows_at(machine, samples)
        return lambda value: _narrowed(windows_m, allowed + [value, -value])

    def on_strokes(samples: PoseSamples, windows_m: FloatArray) -> RegionFilter:
        left = ActuatorRange(_STROKES, machine.strokes_m).margins(samples).min(axis=1)
        # Poses with an x of their own may be anywhere within the strokes.
        own = windows_m[:, 0] == windows_m[:, 1]
        return threshold_filter(np.where(own, np.inf, left), windows_m, at_most=False)

    def smaller(key: str, prepare: Callable[[PoseSamples, FloatArray], RegionFilter]) -> Relaxation:
        configured = getattr(config.refine, key)
        steps = np.arange(np.ceil(configured / _MARGIN_STEP_M - _ROUNDING) - 1.0, -1.0, -1.0)
        levels = (_MARGIN_STEP_M * steps).round(9)
        return Relaxation.of_one_table(
            f"refine.{key}", configured, levels, lambda value: with_values(config, "refine", **{key: value}), prepare
        )

    return [smaller("travel_margin_m", on_rails), smaller("stroke_margin_m", on_strokes)]


def _windows_at(machine: Machine, samples: PoseSamples) -> FloatArray:
    """Compute the x windows (n, 2) of poses that have some x."""
    at_zero = samples.q_m.copy()
    at_zero[:, :3] -= samples.pose[:, :1]
    return x_windows(machine, at_zero)


def _narrowed(windows_m: FloatArray, allowed_m: FloatArray) -> tuple[FloatArray, BoolArray]:
    """Cut windows of x (n, 2) down to what cart travel allows, and return which are not empty."""
    low, high = np.maximum(windows_m[:, 0], allowed_m[:, 0]), np.minimum(windows_m[:, 1], allowed_m[:, 1])
    # Poses with an x of their own are on the rails; rounding must not throw them off.
    own = windows_m[:, 0] == windows_m[:, 1]
    windows = np.where(own[:, None], windows_m, np.column_stack([low, high]))
    return windows, windows[:, 0] <= windows[:, 1]


def _premises(config: Config) -> dict[str, Any]:
    visits = [pose.model_dump(mode="json") for pose in list(given_poses(config).values())[2:]]
    margins = {key: getattr(config.refine, key) for key in ("travel_margin_m", "stroke_margin_m")}
    return {"actuators": {**margins, "visits": visits}}


CERTIFICATE = CertificateEntry((_POSITIONS,), _premises)
MEASURES: tuple[Measure, ...] = tuple(
    Measure(
        key=f"min_{key}_margin_m",
        name=f"least distance to an end of a {what}",
        unit="m",
        prefers="higher",
        resolution=1e-4,
        reduce=reduce,
    )
    for key, what, reduce in (
        ("travel", "rail", lambda samples: float(cart_travel(samples.machine).margins(samples).min())),
        (
            "stroke",
            "stroke",
            lambda samples: float(ActuatorRange(_STROKES, samples.machine.strokes_m).margins(samples).min()),
        ),
    )
)
