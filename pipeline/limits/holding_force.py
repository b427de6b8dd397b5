"""The forces that hold the machine against gravity, with its load, within a fraction of the force limits.

At rest, dry friction of a drive carries part of the force; in motion it has to be overcome. With F for the force
without friction, R for friction and L for the limit of the force, each in the direction of the sign in front of F,

    +/- F <= holding_fraction L + R     at rest, and necessary in motion
    +/- F <= holding_fraction L - R     while the actuator moves in that direction

Carts are pushed (F > 0) along +X; a telescope or link that pushes is compressed. Links have no friction. Regions, ends
and the workspace are judged at rest. x is free in moves between regions, so that strokes alone have a direction there.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from pipeline.arrays import BoolArray, FloatArray, IntArray
from pipeline.config import Config
from pipeline.limits.interface.limit import Curve, Limit, Wording
from pipeline.limits.interface.measure import Measure
from pipeline.limits.interface.proof import CertificateEntry, CertificateKey, ProvenQuantity, Side
from pipeline.limits.interface.relaxation import RegionFilter, Relaxation, threshold_filter, with_values
from pipeline.machine.geometry import ACTUATORS, LINKS, Machine
from pipeline.machine.masses import Masses
from pipeline.machine.samples import PoseSamples

if TYPE_CHECKING:
    from pipeline.inclusion.proven_box import ProvenBox
    from pipeline.limits.interface.rows import Nodes, ProgramPart

_KEY = "machine.limits.holding_fraction"
SUBJECTS = (*ACTUATORS, *(f"link {link}" for link in LINKS))
_FORCES = CertificateKey("holding_force_n", Side.BOTH, SUBJECTS, "holding force of {}", "N", 1, optional=True)
PROOF_SLACK = 1e-3
"""Share of a force, and of five times its range, that bounds are weakened by: then other arithmetic verifies them."""
_NODE_MARGIN = 0.005
"""Part of a force limit that nodes keep on top, for what happens between them."""
FORCES_KEY = "force limits of machine.limits"
"""Key of the relaxation of the force limits; its values are what all of them are multiplied by."""
_STEP, _LARGEST_FACTOR = 0.01, 10.0


@dataclass(frozen=True, eq=False)
class HoldingForce:
    """Every drive and link holds the machine with the force it may take.

    Forces come in columns: at rest, the push and then the pull of every subject with a limit; then the push in positive
    and the pull in negative motion of every actuator of `moving`.

    Attributes
    ----------
    limit_n : (2, 11)
        Largest push and pull, infinite where there is no limit: of c1, c2, c3, l2b, l3b and of the six links.
    friction_n : (11,)
        Dry friction.
    fraction : float
        Part of the limits that holding may take.
    masses : Masses
        What forces follow from.
    moving : (k,)
        Actuators whose friction counts against their motion.
    """

    limit_n: FloatArray
    friction_n: FloatArray
    fraction: float
    masses: Masses
    moving: IntArray
    cost: int = 4
    rounding: float = 1e-9
    slack: float = 0.001
    near: float = 0.1
    least: float = 0.0

    @property
    def wording(self) -> Wording:
        """How the limit is named in messages."""
        return Wording(
            name="holding force",
            key=_KEY,
            rejected_move="a drive or link cannot hold or move the machine",
            refused_points="take more force to hold than machine.limits and holding_fraction allow",
            broken_path="force to hold or move the machine too large, newtons",
            path_advice="Raise refine.nodes, machine.limits or holding_fraction, or lighten machine.dynamics.",
            proof_advice="Raise machine.limits or holding_fraction, or lighten machine.dynamics.",
            raise_key=_KEY if self.fraction < 1.0 else FORCES_KEY,
        )

    @property
    def requirement(self) -> str:
        """What it asks for, in a few words."""
        return f"held within {'' if self.fraction == 1.0 else f'{self.fraction:g} of '}the force limits"

    @property
    def limited(self) -> IntArray:
        """Numbers of the subjects with a limit, ascending."""
        return np.flatnonzero(np.isfinite(self.limit_n).all(axis=0))

    @property
    def resting_columns(self) -> int:
        """Number of columns at rest, which come first."""
        return 2 * len(self.limited)

    @property
    def column_subjects(self) -> IntArray:
        """Number of the subject of each column, shape (m,)."""
        return np.concatenate([self.limited, self.limited, self.moving, self.moving])

    @property
    def column_signs(self) -> IntArray:
        """Sign of the force of each column: 1 for push, -1 for pull. Shape (m,)."""
        return np.repeat([1, -1, 1, -1], [len(self.limited)] * 2 + [len(self.moving)] * 2)

    @property
    def column_limits_n(self) -> FloatArray:
        """Force limit of each column, shape (m,)."""
        return self.limit_n[np.where(self.column_signs > 0, 0, 1), self.column_subjects]

    @property
    def allowed_at_rest_n(self) -> FloatArray:
        """Largest push and pull at rest, where friction helps, shape (2, 11)."""
        return self.fraction * self.limit_n + self.friction_n

    @property
    def allowed_n(self) -> FloatArray:
        """Largest force of each column, friction counted in, shape (m,)."""
        friction = self.friction_n[self.column_subjects]
        at_rest = np.arange(len(friction)) < self.resting_columns
        return np.asarray(self.fraction * self.column_limits_n + np.where(at_rest, friction, -friction), dtype=float)

    def _forces_n(self, samples: PoseSamples) -> FloatArray:
        """Forces of the columns, shape (n, m)."""
        return np.asarray(self.column_signs * samples.holding_forces_n[:, self.column_subjects], dtype=float)

    def applies(self, directions: FloatArray) -> BoolArray:
        """Tell which columns count for poses passed with actuators moving in `directions` (n, 5): signs. (n, m)."""
        moving = directions[:, self.moving]
        at_rest = np.ones((len(directions), self.resting_columns), dtype=bool)
        return np.concatenate([at_rest, moving > 0.0, moving < 0.0], axis=1)

    def blocked(self, samples: PoseSamples) -> BoolArray:
        """Tell in which directions the actuators of `moving` cannot be moved. Shape (n, 5, 2)."""
        found = np.zeros((len(samples), len(ACTUATORS), 2), dtype=bool)
        margins = self.margins(samples)[:, self.resting_columns :]
        found[:, self.moving] = np.stack(np.split(margins < 0.0, 2, axis=1), axis=-1)
        return found

    def margins(self, samples: PoseSamples) -> FloatArray:
        """Compute (allowed - F) / (L + |F|): continuous, and -1 or 1 at a Type-II singularity. Shape (n, m)."""
        force = self._forces_n(samples)
        finite = np.where(np.isfinite(force), force, 0.0)
        margins = (self.allowed_n - finite) / (self.column_limits_n + np.abs(finite))
        return np.where(np.isfinite(force), margins, -np.sign(force))

    def values(self, samples: PoseSamples) -> FloatArray:
        """Compute (allowed - F) / L, shape (n, m)."""
        return np.asarray((self.allowed_n - self._forces_n(samples)) / self.column_limits_n, dtype=float)

    def excess(self, samples: PoseSamples) -> FloatArray:
        """By how many newtons each column's force is too large, shape (n, m)."""
        return np.asarray(self._forces_n(samples) - self.allowed_n, dtype=float)

    def violations(self, samples: PoseSamples) -> list[str]:
        """State every drive and link that cannot hold the machine."""
        broken = self.column_subjects[self.margins(samples)[0] < 0.0]
        return [self._violation(int(k), float(samples.holding_forces_n[0, k])) for k in dict.fromkeys(broken)]

    def _violation(self, subject: int, force_n: float) -> str:
        side = 0 if force_n > 0.0 else 1
        limit, friction = self.limit_n[:, subject], self.friction_n[subject]
        which = "" if limit[0] == limit[1] else ("of push ", "of pull ")[side]
        part = f"{self.fraction:g} of " if self.fraction != 1.0 else ""
        more = f", and {friction:g} N of dry friction" if friction > 0.0 else ""
        allowed = f"{self.allowed_at_rest_n[side, subject]:.4g} N is allowed"
        needed = f"needs {abs(force_n):.0f} N {which}from {SUBJECTS[subject]} to hold the machine"
        return f"{needed}; at most {allowed} ({part}its force limit of {limit[side]:g} N{more})"

    def curves(self, samples: PoseSamples) -> Sequence[Curve]:
        """Return the largest share that holding at rest takes of what is allowed there."""
        return (Curve("holding force", "of allowed", self.shares(samples).max(axis=1), -np.inf, 1.0),)

    def shares(self, samples: PoseSamples) -> FloatArray:
        """Compute |F| / allowed at rest for every subject with a limit, shape (n, subjects)."""
        forces, (push, pull) = samples.holding_forces_n[:, self.limited], self.allowed_at_rest_n[:, self.limited]
        return np.asarray(np.maximum(forces / push, -forces / pull), dtype=float)

    @property
    def quantities(self) -> tuple[ProvenQuantity, ...]:
        """The forces of all drives and links, held at rest."""
        allowed = zip(SUBJECTS, *self.allowed_at_rest_n.tolist(), strict=True)
        return tuple(ProvenQuantity(_FORCES, name, (-pull, push)) for name, push, pull in allowed)

    def bound(self, box: "ProvenBox") -> FloatArray:
        """Bound all forces over a proven box from below and above, shape (11, 2)."""
        from pipeline.inclusion.gravity.forces import holding_force_ranges

        least, largest = holding_force_ranges(box, self.masses).T
        slack = PROOF_SLACK * (np.maximum(np.abs(least), np.abs(largest)) + 5.0 * (largest - least))
        return np.column_stack([least - slack, largest + slack])

    def unproven(self, bounds: FloatArray) -> str:
        """State the force that is not proven to be within its limit."""
        push, pull = self.allowed_at_rest_n[:, self.limited]
        shares = np.column_stack([-bounds[self.limited, 0] / pull, bounds[self.limited, 1] / push])
        if (shares <= 1.0).all():
            return ""
        row, side = np.unravel_index(shares.argmax(), shares.shape)
        worst = self.limited[row]
        return f"{SUBJECTS[worst]} is not proven to hold the machine (bound {abs(bounds[worst, side]):.4g} N)"

    def node_margin(self, clearance_margin_m: float) -> float:
        """Return what nodes keep on top, as part of the force limit."""
        return _NODE_MARGIN

    def program_part(self, nodes: "Nodes") -> "ProgramPart":
        """Write H f = w with the links' forces f as unknowns, at inner nodes near a limit, and bound all forces."""
        from pipeline.limits.program_rows.holding_force import holding_part

        return holding_part(self, _NODE_MARGIN, nodes)


def holding_limit(machine: Machine, moving: Sequence[int] = ()) -> HoldingForce | None:
    """Build the limit with friction against the motion of some actuators; None without masses or force limits."""
    limit = machine.force_limits_n
    if machine.masses is None or np.isinf(limit).all():
        return None
    friction = np.append(machine.masses.friction_n, np.zeros(len(LINKS)))
    counts = [k for k in moving if friction[k] > 0.0 and np.isfinite(limit[:, k]).all()]
    return HoldingForce(limit, friction, machine.holding_fraction, machine.masses, np.array(counts, dtype=np.int64))


def _limits(machine: Machine, moving: Sequence[int]) -> list[Limit]:
    return [limit for limit in [holding_limit(machine, moving)] if limit is not None]


def for_poses(machine: Machine, kappa_max: float) -> list[Limit]:
    """Return the limit at rest; none without masses or force limits."""
    return _limits(machine, ())


def for_moves(config: Config, machine: Machine) -> list[Limit]:
    """Return the limit with the telescopes in motion."""
    return _limits(machine, (3, 4))


def for_path(config: Config, machine: Machine) -> list[Limit]:
    """Return the limit with all actuators in motion."""
    return _limits(machine, range(len(ACTUATORS)))


def relaxations(config: Config, machine: Machine) -> list[Relaxation]:
    """Return larger fractions up to 1, and force limits that are all a hundredth or more higher."""
    limit = holding_limit(machine)
    if limit is None:
        return []
    configured, given = machine.holding_fraction, config.machine.limits

    def with_fraction(value: float) -> Config:
        return with_values(config, "machine", limits=given.model_copy(update={"holding_fraction": value}))

    def with_forces(value: float) -> Config:
        return with_values(config, "machine", limits=given.with_forces(value))

    def prepare(of_one: float) -> Callable[[PoseSamples, FloatArray], RegionFilter]:
        """Filter by what holding takes of the limits, where a value of 1 stands for the fraction `of_one`."""
        return lambda samples, windows_m: threshold_filter(
            (configured - limit.values(samples).min(axis=1)) / of_one, windows_m
        )

    fractions = _STEP * np.arange(int(np.floor(configured / _STEP + 1e-9)) + 1.0, round(1.0 / _STEP) + 1)
    factors = _STEP * np.arange(round(1.0 / _STEP) + 1.0, round(_LARGEST_FACTOR / _STEP) + 1)
    return [
        Relaxation.of_one_table(_KEY, configured, fractions.round(9), with_fraction, prepare(1.0)),
        Relaxation.of_one_table(FORCES_KEY, 1.0, factors.round(9), with_forces, prepare(configured)),
    ]


def _premises(config: Config) -> dict[str, Any]:
    return {"holding": holding} if (holding := config.machine.holding()) else {}


def _largest_share(samples: PoseSamples) -> float:
    """Reduce to the largest share of what is allowed at rest; NaN if no forces are limited."""
    limit = holding_limit(samples.machine)
    return np.nan if limit is None else float(limit.shares(samples).max())


MEASURES: tuple[Measure, ...] = (
    Measure(
        key="max_holding_force",
        name="largest holding force",
        unit="of allowed",
        prefers="lower",
        resolution=1e-4,
        reduce=_largest_share,
    ),
)
CERTIFICATE = CertificateEntry((_FORCES,), _premises)
