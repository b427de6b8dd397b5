"""The cap on kappa, and with it the distance from Type-II singularities."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from pipeline.arrays import FloatArray
from pipeline.config import Config
from pipeline.errors import ConfigError, ConfigIssue
from pipeline.limits.interface.limit import Curve, Limit, Wording
from pipeline.limits.interface.measure import Measure
from pipeline.limits.interface.proof import CertificateEntry, CertificateKey, ProvenQuantity, Side
from pipeline.limits.interface.relaxation import Relaxation, threshold_filter, with_values
from pipeline.machine.geometry import Machine
from pipeline.machine.samples import PoseSamples

if TYPE_CHECKING:
    from pipeline.inclusion.proven_box import ProvenBox

PROOF_MARGIN, PROOF_MARGIN_WITH_ERRORS = 3e-4, 0.01
"""Relative slack of proven bounds of kappa, so that other arithmetic can verify them."""
KAPPA = CertificateKey("kappa", Side.LARGEST, label="κ")
DET_SIGN = CertificateKey("det_sign", Side.SIGN, label="sign of det H")
_LARGEST_CAP, _CAPS_PER_DECADE = 1_000.0, 1_000


@dataclass(frozen=True, eq=False)
class KappaCap:
    """kappa <= cap. The margin is 1/kappa - 1/cap, which is continuous through a singularity.

    Attributes
    ----------
    cap : float
        Largest kappa.
    key : str
        Configuration key of the cap.
    """

    cap: float
    key: str = "route.kappa_max"
    cost: int = 2
    rounding: float = 1e-12
    proven_under_error: bool = True

    @property
    def wording(self) -> Wording:
        """How the limit is named in messages."""
        return Wording(
            name="kappa",
            key=self.key,
            rejected_move="kappa exceeds its cap",
            refused_points=f"have kappa above {self.key} ({self.cap:g})",
            broken_path="kappa above its cap",
            path_advice="Raise refine.kappa_max, route.kappa_max or refine.corridor_cells.",
            proof_advice="Raise refine.kappa_max, or give the path more room.",
            raise_key="route.kappa_max",
        )

    @property
    def requirement(self) -> str:
        """What it asks for, in a few words."""
        return f"kappa at most {self.cap:g}"

    def margins(self, samples: PoseSamples) -> FloatArray:
        """Compute 1/kappa - 1/cap, shape (n, 1)."""
        return np.abs(samples.signed_inverse_kappa)[:, None] - 1.0 / self.cap

    def excess(self, samples: PoseSamples) -> FloatArray:
        """Compute kappa - cap, shape (n, 1)."""
        return np.asarray(samples.kappa[:, None] - self.cap, dtype=float)

    def violations(self, samples: PoseSamples) -> list[str]:
        """State a kappa above the cap, and whether that is for want of a characteristic length."""
        if self.margins(samples)[0, 0] >= 0.0:
            return []
        length_m, kappa = kappa_for_link_length(samples)
        stated = f"has kappa {samples.kappa[0]:.1f}, above {self.key} ({self.cap:g})"
        if kappa <= self.cap:
            key = "machine.characteristic_length_m"
            stated += f"; with {key}: {length_m:g}, the mean length of the links, it would be {kappa:.1f}"
        return [stated]

    def readings(self, samples: PoseSamples) -> Sequence[Curve]:
        """Return kappa."""
        return (Curve("kappa", "", samples.kappa, -np.inf, self.cap),)

    @property
    def quantities(self) -> tuple[ProvenQuantity, ...]:
        """Kappa, and the sign of det H."""
        return (
            ProvenQuantity(KAPPA, KAPPA.name, (-np.inf, self.cap)),
            ProvenQuantity(DET_SIGN, DET_SIGN.name, (-1.0, 1.0)),
        )

    def bound(self, box: "ProvenBox") -> FloatArray:
        """Bound kappa and the sign of det H over a proven box, shape (2, 2)."""
        from pipeline.inclusion.condition import kappa_bound

        found = kappa_bound(box.balls, box.series, box.displacement, box.erring)
        margin = PROOF_MARGIN if box.erring is None and box.ellipsoid is None else PROOF_MARGIN_WITH_ERRORS
        return np.array([[-np.inf, found.kappa * (1.0 + margin)], [found.det_sign, found.det_sign]])

    def unproven(self, bounds: FloatArray) -> str:
        """State that kappa is not proven below its cap."""
        kappa = float(bounds[0, 1])
        return "" if kappa <= self.cap else f"kappa is not proven below its cap {self.cap:g} (bound {kappa:.4g})"


def kappa_for_link_length(samples: PoseSamples) -> tuple[float, float]:
    """Compute kappa of a single pose (n = 1) for the mean length of the links as characteristic length.

    Returns
    -------
    length_m, kappa : float
        That length to two digits, and kappa with it.
    """
    length_m = float(f"{np.nanmean(samples.machine.lengths_m):.2g}")
    machine = replace(samples.machine, characteristic_length_m=length_m)
    return length_m, float(PoseSamples(machine, samples.pose, samples.q_m).kappa[0])


def path_cap(config: Config) -> float:
    """Return the cap on kappa along a path: the smaller of refine.kappa_max, if given, and route.kappa_max."""
    return min(config.refine.kappa_max or np.inf, config.route.kappa_max)


def require_ends_below_cap(config: Config, kappas: Sequence[float]) -> None:
    """Check that the cap on the path's kappa leaves room for start and goal, whose kappas are given.

    Raises
    ------
    ConfigError
        If refine.kappa_max is below one of them.
    """
    cap, largest = config.refine.kappa_max, max(kappas)
    if cap is not None and cap < largest:
        raise ConfigError(
            [ConfigIssue("refine.kappa_max", f"is {cap:g}; kappa at the start or the goal is {largest:.2f}")]
        )


def for_poses(machine: Machine, kappa_max: float) -> list[Limit]:
    """Return the limit of poses by themselves."""
    return [KappaCap(kappa_max)]


def for_moves(config: Config, machine: Machine) -> list[Limit]:
    """Return the limit of moves between regions."""
    return [KappaCap(config.route.kappa_max)]


def for_path(config: Config, machine: Machine) -> list[Limit]:
    """Return the limit of a path."""
    cap = path_cap(config)
    return [KappaCap(cap, "route.kappa_max" if cap == config.route.kappa_max else "refine.kappa_max")]


def relaxations(config: Config, machine: Machine) -> list[Relaxation]:
    """Return caps above the configured one: whole numbers up to 1,000, then a quarter of a percent apart."""
    configured = config.route.kappa_max
    whole = np.arange(np.floor(configured) + 1.0, _LARGEST_CAP + 0.5)
    top, bound = max(_LARGEST_CAP, configured), 10.0 * configured
    count = int(np.ceil(_CAPS_PER_DECADE * np.log10(max(bound / top, 1.0))))
    higher = np.concatenate([whole, np.geomspace(top, max(bound, top), count + 1)[1:]])
    return [
        Relaxation.of_one_table(
            key="route.kappa_max",
            configured=configured,
            milder=higher,
            change=lambda value: with_values(config, "route", kappa_max=value),
            prepare=lambda samples, windows_m: threshold_filter(samples.kappa, windows_m),
        )
    ]


CERTIFICATE = CertificateEntry((KAPPA, DET_SIGN), lambda config: {"kappa_max": path_cap(config)})
MEASURES: tuple[Measure, ...] = ()
