"""The least stiffness that gravity gives the drives: where it is too negative, they cannot hold the machine.

With F(q) for the forces that hold the machine, K = dF/dq along the closures is symmetric: the Hessian of the potential
energy in actuator space. Drives of stiffness k hold a pose if k 1 + K is positive definite, hence

    least eigenvalue of K >= machine.limits.gravity_stiffness_npm.

K (1, 1, 1, 0, 0)' = 0: all carts moved alike carry the machine along, and no force changes. The least eigenvalue is
therefore never positive, and neither can the limit be.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from pipeline.arrays import FloatArray
from pipeline.config import Config
from pipeline.limits.interface.limit import Curve, Limit, Wording
from pipeline.limits.interface.measure import Measure
from pipeline.limits.interface.proof import CertificateEntry, CertificateKey, ProvenQuantity, Side
from pipeline.limits.interface.relaxation import Relaxation, threshold_filter, with_values
from pipeline.machine.actuator_space import actuator_rates, gravity_stiffness, mode_words
from pipeline.machine.geometry import Machine
from pipeline.machine.masses import Masses
from pipeline.machine.samples import PoseSamples

if TYPE_CHECKING:
    from pipeline.inclusion.proven_box import ProvenBox
    from pipeline.limits.interface.rows import Nodes, ProgramPart

_KEY = "machine.limits.gravity_stiffness_npm"
STIFFNESS = CertificateKey(
    "gravity_stiffness_npm", Side.FLOOR, label="gravity stiffness", unit="N/m", decimals=0, optional=True
)
PROOF_SLACK, _REST_SLACK = 1e-3, 0.2
"""Shares of the bound, and of what it gives away for the width of a box, that it is weakened by: then other arithmetic
verifies it."""
_NODE_MARGIN = 0.01
"""Part of the scale that nodes keep on top, for what happens between them."""
_LEAST_SCALE_NPM = 1_000.0
"""Scale of the stiffness where the limit itself is smaller."""
_STEP_NPM, _LARGEST_FACTOR = 100.0, 100.0


@dataclass(frozen=True, eq=False)
class GravityStiffness:
    """The least eigenvalue of K is at least so large.

    Attributes
    ----------
    least_npm : float
        Least allowed, negative.
    masses : Masses
        What forces follow from.
    """

    least_npm: float
    masses: Masses
    cost: int = 5
    rounding: float = 1e-9
    slack: float = 0.001
    near: float = 0.1
    least: float = 0.0

    @property
    def wording(self) -> Wording:
        """How the limit is named in messages."""
        return Wording(
            name="gravity stiffness",
            key=_KEY,
            rejected_move="gravity makes the drives too unstable",
            refused_points=f"have a gravity stiffness below {_KEY} ({self.least_npm:g} N/m)",
            broken_path="gravity stiffness below its limit, newtons per metre",
            path_advice=f"Lower {_KEY}, raise refine.nodes, or lighten machine.dynamics.",
            proof_advice=f"Lower {_KEY}, or lighten machine.dynamics.",
        )

    @property
    def requirement(self) -> str:
        """What it asks for, in a few words."""
        return f"gravity stiffness at least {self.least_npm:g} N/m"

    @property
    def scale_npm(self) -> float:
        """What values are divided by."""
        return max(-self.least_npm, _LEAST_SCALE_NPM)

    def margins(self, samples: PoseSamples) -> FloatArray:
        """Compute (stiffness - least) / (scale + |stiffness|), -1 where the stiffness falls without limit: (n, 1)."""
        stiffness = samples.gravity_stiffness_npm
        finite = np.maximum(stiffness, np.finfo(float).min / 4.0)
        return np.asarray(((finite - self.least_npm) / (self.scale_npm + np.abs(finite)))[:, None], dtype=float)

    def values(self, samples: PoseSamples) -> FloatArray:
        """Compute (stiffness - least) / scale, shape (n, 1)."""
        return np.asarray((samples.gravity_stiffness_npm[:, None] - self.least_npm) / self.scale_npm, dtype=float)

    def excess(self, samples: PoseSamples) -> FloatArray:
        """By how many newtons per metre the stiffness is too small, shape (n, 1)."""
        return np.asarray(self.least_npm - samples.gravity_stiffness_npm[:, None], dtype=float)

    def violations(self, samples: PoseSamples) -> list[str]:
        """State a stiffness below the limit, and the motion of the drives that it belongs to."""
        stiffness = float(samples.gravity_stiffness_npm[0])
        if stiffness >= self.least_npm:
            return []
        along = ""
        if np.isfinite(stiffness):
            rates = actuator_rates(samples.machine, samples.pose, samples.carts_m, samples.H)
            _, directions = np.linalg.eigh(gravity_stiffness(samples.machine, rates)[0])
            along = f" along {mode_words(directions[:, 0])}"
        asked = f"{_KEY} asks for at least {self.least_npm:g} N/m"
        return [f"has a gravity stiffness of {stiffness:.0f} N/m{along}; {asked}"]

    def curves(self, samples: PoseSamples) -> Sequence[Curve]:
        """Return the stiffness at each sample."""
        return (Curve("gravity stiffness", "N/m", samples.gravity_stiffness_npm, self.least_npm, np.inf),)

    @property
    def quantities(self) -> tuple[ProvenQuantity, ...]:
        """The least eigenvalue."""
        return (ProvenQuantity(STIFFNESS, STIFFNESS.name, (self.least_npm, np.inf)),)

    def bound(self, box: "ProvenBox") -> FloatArray:
        """Bound the least eigenvalue over a proven box from below, shape (1, 2)."""
        from pipeline.inclusion.gravity.stiffness import least_stiffness_bound

        least, rest = least_stiffness_bound(box, self.masses)
        return np.array([[least - PROOF_SLACK * abs(least) - _REST_SLACK * rest, np.inf]])

    def unproven(self, bounds: FloatArray) -> str:
        """State that the stiffness is not proven to keep its limit."""
        least = float(bounds[0, 0])
        if least >= self.least_npm:
            return ""
        return f"gravity stiffness is not proven to be at least {self.least_npm:g} N/m (bound {least:.4g} N/m)"

    def node_margin(self, clearance_margin_m: float) -> float:
        """Return what nodes keep on top, as part of the scale."""
        return _NODE_MARGIN

    def program_part(self, nodes: "Nodes") -> "ProgramPart":
        """Write that K less the limit is positive definite, at inner nodes that come near it."""
        from pipeline.limits.program_rows.gravity_stiffness import stiffness_part

        return stiffness_part(self, _NODE_MARGIN, nodes)


def stiffness_limit(machine: Machine) -> GravityStiffness | None:
    """Build the limit; None without masses or without a limit."""
    if machine.masses is None or np.isinf(machine.gravity_stiffness_npm):
        return None
    return GravityStiffness(machine.gravity_stiffness_npm, machine.masses)


def _limits(machine: Machine) -> list[Limit]:
    return [limit for limit in [stiffness_limit(machine)] if limit is not None]


def for_poses(machine: Machine, kappa_max: float) -> list[Limit]:
    """Return the limit of poses by themselves."""
    return _limits(machine)


def for_moves(config: Config, machine: Machine) -> list[Limit]:
    """Return the limit of moves between regions."""
    return _limits(machine)


def for_path(config: Config, machine: Machine) -> list[Limit]:
    """Return the limit of a path."""
    return _limits(machine)


def relaxations(config: Config, machine: Machine) -> list[Relaxation]:
    """Return lower limits: multiples of 100 N/m."""
    if stiffness_limit(machine) is None:
        return []
    configured, given = machine.gravity_stiffness_npm, config.machine.limits

    def change(value: float) -> Config:
        limits = given.model_copy(update={"gravity_stiffness_npm": value})
        return with_values(config, "machine", limits=limits)

    first = np.floor(-configured / _STEP_NPM + 1e-9) + 1.0
    last = max(_LARGEST_FACTOR * first, 1_000.0)
    lower = -_STEP_NPM * np.unique(np.append(np.arange(first, 1_001.0), np.geomspace(first, last, 1_000).round()))
    return [
        Relaxation.of_one_table(
            key=_KEY,
            configured=configured,
            milder=np.sort(lower)[::-1],
            change=change,
            prepare=lambda samples, windows_m: threshold_filter(
                samples.gravity_stiffness_npm, windows_m, at_most=False
            ),
        )
    ]


def _premises(config: Config) -> dict[str, Any]:
    limited = config.machine.limits.gravity_stiffness_npm is not None
    return {"gravity_stiffness": config.machine.holding()} if limited else {}


def _least(samples: PoseSamples) -> float:
    """Reduce to the least stiffness; NaN without masses."""
    return np.nan if samples.machine.masses is None else float(samples.gravity_stiffness_npm.min())


MEASURES: tuple[Measure, ...] = (
    Measure(
        key="min_gravity_stiffness_npm",
        name="least gravity stiffness",
        unit="N/m",
        prefers="higher",
        resolution=1.0,
        reduce=_least,
    ),
)
CERTIFICATE = CertificateEntry((STIFFNESS,), _premises)
