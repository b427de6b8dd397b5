"""The largest tilt about x and z, and locked tilt axes."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from pipeline.arrays import FloatArray
from pipeline.config import Config
from pipeline.limits.interface.limit import Curve, Limit, Wording
from pipeline.limits.interface.measure import Measure
from pipeline.limits.interface.proof import CertificateEntry, CertificateKey, ProvenQuantity, Side
from pipeline.limits.interface.relaxation import Relaxation, threshold_filter, with_values
from pipeline.machine.geometry import Machine
from pipeline.machine.pose import TILT_AXES, TILT_COLUMNS
from pipeline.machine.samples import PoseSamples

if TYPE_CHECKING:
    from pipeline.inclusion.proven_box import ProvenBox

PROOF_SLACK_RAD = 1e-5
"""What proven bounds are weakened by, so that other arithmetic can verify them."""
PROOF_ROUNDING_RAD = 1e-6
"""By how much a bound may pass a limit that the path was made to touch."""
_TILT = CertificateKey("tilt_deg", Side.LARGEST, TILT_AXES, "|{}|", "°", 2)
_LOCK_SHARE = 0.8
"""Part of a locked axis' tolerance allowed at nodes; the rest is for what happens between them."""
_BOUND_DEG, _LARGEST_DEG = 45.0, 85.0
_ROUNDING = 1e-9


@dataclass(frozen=True, eq=False)
class TiltLimit:
    """|rx| and |rz| stay within their limits.

    Attributes
    ----------
    largest_rad : (2,)
        Largest |rx| and |rz|.
    """

    largest_rad: FloatArray
    cost: int = 0
    rounding: float = float(np.deg2rad(1e-9))

    @property
    def wording(self) -> Wording:
        """How the limit is named in messages."""
        return Wording(
            name="tilt",
            key="task.tilt_max_deg",
            rejected_move="the platform tilts too far",
            refused_points="tilt farther than task.tilt_max_deg",
            broken_path="tilt too large, degrees",
            path_advice="Raise refine.tilt_margin_deg, refine.nodes or, for a locked axis, refine.lock_tolerance_deg.",
            proof_advice="Raise refine.tilt_margin_deg.",
            raise_key="task.tilt_max_deg",
        )

    @property
    def requirement(self) -> str:
        """What it asks for, in a few words."""
        least, largest = np.rad2deg(self.largest_rad)
        return f"|rx| at most {least:g} deg, |rz| at most {largest:g} deg"

    def margins(self, samples: PoseSamples) -> FloatArray:
        """Compute what is left of the limits in both directions, shape (n, 4)."""
        tilt = samples.pose[:, TILT_COLUMNS]
        return np.concatenate([self.largest_rad - tilt, self.largest_rad + tilt], axis=1)

    def excess(self, samples: PoseSamples) -> FloatArray:
        """By how many degrees the platform tilts too far, shape (n, 4)."""
        return np.asarray(-np.rad2deg(self.margins(samples)), dtype=float)

    def violations(self, samples: PoseSamples) -> list[str]:
        """State every tilt beyond its limit."""
        tilt, largest = np.rad2deg(np.abs(samples.pose[0, TILT_COLUMNS])), np.rad2deg(self.largest_rad)
        rows = zip(TILT_AXES, tilt, largest, strict=True)
        return [f"has |{axis}| {value:.3g} degrees; allowed is {most:g}" for axis, value, most in rows if value > most]

    def curves(self, samples: PoseSamples) -> Sequence[Curve]:
        """Return both tilts in degrees."""
        degrees = np.rad2deg(samples.pose[:, TILT_COLUMNS])
        # Degrees as they were typed, without the rounding of the conversion.
        rows = zip(TILT_AXES, degrees.T, np.rad2deg(self.largest_rad).round(12).tolist(), strict=True)
        return tuple(Curve(axis, "deg", values, -limit, limit) for axis, values, limit in rows)

    @property
    def quantities(self) -> tuple[ProvenQuantity, ...]:
        """|rx| and |rz|."""
        largest = zip(TILT_AXES, np.rad2deg(self.largest_rad).tolist(), strict=True)
        return tuple(ProvenQuantity(_TILT, axis, (-np.inf, limit)) for axis, limit in largest)

    def bound(self, box: "ProvenBox") -> FloatArray:
        """Bound |rx| and |rz| over a proven box from above, in degrees, shape (2, 2)."""
        from pipeline.inclusion.bounds import tilt_magnitudes

        largest = np.rad2deg(tilt_magnitudes(box) + PROOF_SLACK_RAD)
        return np.column_stack([np.full(2, -np.inf), largest])

    def unproven(self, bounds: FloatArray) -> str:
        """State the tilt that is not proven to stay within its limit."""
        excess = bounds[:, 1] - np.rad2deg(self.largest_rad)
        if excess.max() <= np.rad2deg(PROOF_ROUNDING_RAD + PROOF_SLACK_RAD):
            return ""
        worst = int(excess.argmax())
        return f"{TILT_AXES[worst]} is not proven to stay within its limit (beyond by {excess[worst]:.3g} degrees)"


def path_limits_deg(config: Config) -> tuple[float, ...]:
    """Return the largest |rx| and |rz| along a path: a locked axis has its tolerance."""
    task, tolerance = config.task, config.refine.lock_tolerance_deg
    return tuple(tolerance if axis in task.locked_axes else task.tilt_max_deg for axis in TILT_AXES)


def node_limits_rad(config: Config) -> tuple[float, ...]:
    """Return the largest |rx| and |rz| at nodes: less by refine.tilt_margin_deg, or a part of a lock's tolerance."""
    task, options = config.task, config.refine
    locked = _LOCK_SHARE * float(np.deg2rad(options.lock_tolerance_deg))
    free = max(float(np.deg2rad(task.tilt_max_deg - options.tilt_margin_deg)), 0.0)
    return tuple(locked if axis in task.locked_axes else free for axis in TILT_AXES)


def for_poses(machine: Machine, kappa_max: float) -> list[Limit]:
    """Return no limit: tilts of regions are those of the grid."""
    return []


def for_moves(config: Config, machine: Machine) -> list[Limit]:
    """Return the limit of moves, which may overshoot by route.follow.tilt_overshoot_deg between two regions."""
    largest = np.deg2rad(config.task.tilt_max_deg + config.route.follow.tilt_overshoot_deg)
    return [TiltLimit(np.full(2, largest))]


def for_path(config: Config, machine: Machine) -> list[Limit]:
    """Return the limit of a path."""
    return [TiltLimit(np.deg2rad(path_limits_deg(config)))]


def relaxations(config: Config, machine: Machine) -> list[Relaxation]:
    """Return the tilt limit with the axes locked as configured, then with each and all of the locked ones free."""
    locked = tuple(config.task.locked_axes)
    found = [_with_locked(config, locked)] if len(locked) < 2 else []
    kept = [tuple(axis for axis in locked if axis != free) for free in locked] + [()]
    return found + [_with_locked(config, axes) for axes in dict.fromkeys(kept) if axes != locked]


def _with_locked(config: Config, locked: tuple[str, ...]) -> Relaxation:
    task, grid, unlocks = config.task, config.route.grid, locked != tuple(config.task.locked_axes)
    # Given poses may be tilted: less than that is no value of the key, and with as much a freed axis may do.
    poses = [task.start, task.goal, *(visit.pose for visit in task.visit if visit.pose is not None)]
    given = max(abs(tilt) for pose in poses for tilt in (pose.rx_deg, pose.rz_deg))
    least = given if unlocks else task.tilt_max_deg
    bound = _BOUND_DEG if task.tilt_max_deg < _BOUND_DEG else _LARGEST_DEG
    steps = [step for axis, step in (("rx", grid.rx_step_deg), ("rz", grid.rz_step_deg)) if axis not in locked]
    multiples = np.concatenate([step * np.arange(1, int(bound / step + _ROUNDING) + 1) for step in steps])
    refused = 0.0 if unlocks else least
    levels = np.unique([refused, least, *multiples[multiples > least + _ROUNDING].round(9)])
    return Relaxation(
        key="task.tilt_max_deg",
        configured=task.tilt_max_deg,
        levels=levels,
        segments=_doubling(len(levels)),
        change=lambda value: with_values(config, "task", tilt_max_deg=value, locked_axes=locked),
        prepare=lambda samples, windows_m: threshold_filter(_needed_deg(samples), windows_m),
        locked_axes=locked if unlocks else None,
    )


def _needed_deg(samples: PoseSamples) -> FloatArray:
    """Compute the tilt limit that each pose needs, less what rounding adds to a tilt of the grid. Shape (n,)."""
    return np.asarray(np.rad2deg(np.abs(samples.pose[:, TILT_COLUMNS]).max(axis=1) - _ROUNDING), dtype=float)


def _doubling(count: int) -> tuple[int, ...]:
    """Return ends of parts that double: tables grow with the square of the tilt, and the least may do."""
    ends = [2**k for k in range(1, 10) if 2**k < count]
    return (*ends, count)


CERTIFICATE = CertificateEntry((_TILT,), lambda config: {"tilt_deg": path_limits_deg(config)})
MEASURES: tuple[Measure, ...] = (
    Measure(
        key="max_tilt_deg",
        name="largest tilt",
        unit="deg",
        prefers="lower",
        resolution=1e-4,
        reduce=lambda samples: float(np.rad2deg(np.abs(samples.pose[:, TILT_COLUMNS]).max())),
    ),
)
