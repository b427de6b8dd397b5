"""A stored certificate checked against its path and configuration: which of its claims are verified."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass

import numpy as np

from pipeline.arrays import FloatArray
from pipeline.certify.premises import premises_sha256
from pipeline.certify.recheck.arithmetic.chain import EvaluatedChain, evaluate_chain, evaluate_ends
from pipeline.certify.recheck.claims import chain, checks, endpoints, inventory
from pipeline.certify.recheck.claims.claim import Claim
from pipeline.certify.recheck.claims.poses import POSES, pose_claim
from pipeline.certify.recheck.claims.splines import SPLINES, spline_claim
from pipeline.certify.recheck.statement import Statement
from pipeline.certify.result import ProvenChain, path_sha256
from pipeline.config import Config
from pipeline.inclusion.uncertainty import Uncertainty
from pipeline.machine.geometry import ACTUATORS, Machine
from pipeline.refine.result import Path
from pipeline.route.regions.endpoints import Endpoint

PATH = "the certificate is of this path"
PREMISES = "the certificate is of this machine, limits, start and goal"
_CONFIGURED = "configured machine"

MANDATORY = (
    PATH,
    PREMISES,
    SPLINES,
    *inventory.CLAIMS,
    *(f"{_CONFIGURED}: {what}" for what in chain.CLAIMS),
    *(what for module in checks.CHECKS for what in module.CLAIMS),
    *endpoints.CLAIMS,
    POSES,
)
"""What has to be verified of any certificate, whatever it contains."""


def verify(
    config: Config, machine: Machine, path: Path, ends: tuple[Endpoint, Endpoint], stated: Statement
) -> list[Claim]:
    """Verify every claim of a certificate without searching for anything; those of `MANDATORY` in any case."""
    path_hash, premises_hash, splines = path_sha256(path), premises_sha256(config), spline_claim(path.spline)
    claims = [
        Claim(PATH, stated.path_sha256 == path_hash, path_hash[:12]),
        Claim(PREMISES, stated.premises_sha256 == premises_hash, premises_hash[:12]),
        splines,
        *inventory.inventory_claims(machine, stated),
    ]

    def measured(segment: EvaluatedChain, before: list[FloatArray] | None) -> list[FloatArray]:
        return checks.measure_all(config, machine, segment, before)

    def bounds_of(found: list[FloatArray]) -> list[Claim]:
        return list(checks.bound_claims(config, machine, found, stated.bounds))

    def ends_of(proven: ProvenChain) -> Iterable[Claim]:
        yield from endpoints.endpoint_claims(machine, ends, evaluate_ends(machine, path, proven), stated.bounds)
        yield pose_claim(path, proven)

    # Boxes say nothing about splines that are not a function.
    if splines.verified:
        for proven in stated.chains:
            claims += _chain_claims(
                machine, path, proven, _Configured(measured, bounds_of, ends_of), refused=_any_refused(claims)
            )
    known = {claim.what for claim in claims}
    absent = "missing, or not evaluated for what else is wrong" if _any_refused(claims) else "missing"
    return claims + [Claim(what, verified=False, found=absent) for what in MANDATORY if what not in known]


@dataclass(frozen=True)
class _Configured:
    """What else is claimed of the chain of the configured machine."""

    measured: Callable[[EvaluatedChain, list[FloatArray] | None], list[FloatArray]]
    bounds_of: Callable[[list[FloatArray]], list[Claim]]
    ends_of: Callable[[ProvenChain], Iterable[Claim]]


def _chain_claims(
    machine: Machine, path: Path, proven: ProvenChain, configured: _Configured, *, refused: bool
) -> list[Claim]:
    """Verify a chain; for the configured machine also the bounds that are stated of it.

    A chain of many segments is evaluated no further than the certificate is refused anyway.
    """
    of, counted, found = _name(proven.uncertainty), chain.BoxCounts(), None
    bounds: list[Claim] = []
    # NaN compares as false: what cannot be computed is not verified.
    with np.errstate(all="ignore"):
        try:
            ends = [] if proven.uncertainty.any else list(configured.ends_of(proven))
            refused |= not chain.closes(proven) or _any_refused(ends)
            for segment in evaluate_chain(machine, path, proven):
                counted += chain.count_boxes(segment)
                if not proven.uncertainty.any:
                    found = configured.measured(segment, found)
                    bounds = configured.bounds_of(found)
                # What is wrong over some boxes is wrong over all: bounds get only wider.
                if counted.boxes < len(proven.boxes) and (refused or not counted.all_hold or _any_refused(bounds)):
                    wrong = [claim for claim in bounds if not claim.verified]
                    return [*chain.chain_claims(of, proven, counted), *wrong, *ends]
            return [*chain.chain_claims(of, proven, counted), *bounds, *ends]
        except (np.linalg.LinAlgError, ValueError, OverflowError):
            text = "some numbers are too large, or give matrices without an inverse"
            return [Claim(f"{of}: its boxes can be evaluated", verified=False, found=text)]


def _any_refused(claims: list[Claim]) -> bool:
    return any(not claim.verified for claim in claims)


def _name(uncertainty: Uncertainty) -> str:
    if not uncertainty.any:
        return _CONFIGURED
    lengths, coordinates = 1e3 * uncertainty.length_m, 1e3 * uncertainty.coordinate_m
    parts = [f"lengths ± {lengths:.4g}, coordinates ± {coordinates:.4g}"] if uncertainty.calibration else []
    if any(errors := uncertainty.actuator_m):
        parts.append(f"{', '.join(ACTUATORS)} ± {', '.join(f'{1e3 * error:.4g}' for error in errors)}")
    return f"{'; '.join(parts)} mm"
