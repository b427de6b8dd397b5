"""A stored certificate checked against its path and configuration: which of its claims are verified."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass

import numpy as np

from pipeline.arrays import FloatArray
from pipeline.certify.premises import premises_sha256
from pipeline.certify.recheck.arithmetic.chain import EvaluatedChain, evaluate_chain, evaluate_ends
from pipeline.certify.recheck.claims import chain, checks, endpoints, errors, inventory, machines
from pipeline.certify.recheck.claims.claim import Claim
from pipeline.certify.recheck.claims.poses import POSES, pose_claim
from pipeline.certify.recheck.claims.splines import SPLINES, spline_claim
from pipeline.certify.recheck.statement import StatedMachines, Statement
from pipeline.certify.result import ProvenChain, path_sha256
from pipeline.config import Config
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
        *machines.range_claims(config, machine, stated),
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
        for proven, reserve in zip(stated.chains, inventory.stated_reserves(stated), strict=True):
            asked = _Asked(measured, bounds_of, ends_of, *_under_error(config, machine), reserve, stated.machines)
            claims += _chain_claims(machine, path, proven, asked, refused=_any_refused(claims))
    known = {claim.what for claim in claims}
    absent = "missing, or not evaluated for what else is wrong" if _any_refused(claims) else "missing"
    return claims + [Claim(what, verified=False, found=absent) for what in MANDATORY if what not in known]


def verifies(config: Config, machine: Machine, path: Path, proven: ProvenChain) -> bool:
    """Return whether a chain of an uncertain machine closes, and keeps the limits if it says so."""
    asked = _Asked(lambda *_: [], lambda _: [], lambda _: [], *_under_error(config, machine), None, None)
    return not _any_refused(_chain_claims(machine, path, proven, asked, refused=False))


_Erring = Callable[[EvaluatedChain, errors.Evidence | None], errors.Evidence]
_Limits = Callable[[str, errors.Evidence], Claim]
_OffPath = Callable[[EvaluatedChain], FloatArray]


def _under_error(config: Config, machine: Machine) -> tuple[_Erring, _Limits, _OffPath]:
    """Give what measures limits under error, claims that they are kept, and what measures how far machines are off."""

    def erring(segment: EvaluatedChain, before: errors.Evidence | None) -> errors.Evidence:
        return errors.measure(config, machine, segment, before)

    def off_path(segment: EvaluatedChain) -> FloatArray:
        return machines.off_path(machine, segment)

    def limits_of(of: str, found: errors.Evidence) -> Claim:
        return errors.limit_claim(of, config, machine, found)

    return erring, limits_of, off_path


@dataclass(frozen=True)
class _Asked:
    """What else is claimed: of the chain of the configured machine, and of chains of following errors."""

    measured: Callable[[EvaluatedChain, list[FloatArray] | None], list[FloatArray]]
    bounds_of: Callable[[list[FloatArray]], list[Claim]]
    ends_of: Callable[[ProvenChain], Iterable[Claim]]
    erring: _Erring
    limits_of: _Limits
    off_path: _OffPath
    reserve_deg: tuple[float, float] | None
    machines: StatedMachines | None


class _Bounds:
    """The claims that follow from bounds over the boxes so far."""

    def __init__(self, of: str, proven: ProvenChain, asked: _Asked) -> None:
        self._of, self._proven, self._asked = of, proven, asked
        self._configured: list[FloatArray] | None = None
        self._erring: errors.Evidence | None = None
        self._tilts, self._off = np.zeros(2), np.zeros(7)
        self.claims: list[Claim] = []

    def add(self, segment: EvaluatedChain) -> None:
        """Take a segment of boxes into account."""
        self.claims = []
        if _is_configured(self._proven):
            self._configured = self._asked.measured(segment, self._configured)
            self.claims += self._asked.bounds_of(self._configured)
        if self._proven.within_limits:
            self._erring = self._asked.erring(segment, self._erring)
            self.claims.append(self._asked.limits_of(self._of, self._erring))
        if segment.ellipsoid is not None:
            self._off = np.maximum(self._off, self._asked.off_path(segment))
            self.claims.append(machines.reserve_claim(self._of, self._off, self._asked.machines))
            return
        self._tilts = np.maximum(self._tilts, errors.tilts_off_deg(segment))
        self.claims += errors.reserve_claims(self._of, self._tilts, self._asked.reserve_deg)


def _is_configured(proven: ProvenChain) -> bool:
    return not (proven.uncertainty.any or proven.within_limits or proven.profile_m)


def _chain_claims(machine: Machine, path: Path, proven: ProvenChain, asked: _Asked, *, refused: bool) -> list[Claim]:
    """Verify a chain; for the configured machine also the bounds that are stated of it.

    A chain of many segments is evaluated no further than the certificate is refused anyway.
    """
    of, counted = _name(proven), chain.BoxCounts()
    bounds = _Bounds(of, proven, asked)
    # NaN compares as false: what cannot be computed is not verified.
    with np.errstate(all="ignore"):
        try:
            ends = list(asked.ends_of(proven)) if _is_configured(proven) else []
            refused |= not chain.closes(proven) or _any_refused(ends)
            for segment in evaluate_chain(machine, path, proven):
                counted += chain.count_boxes(segment)
                bounds.add(segment)
                # What is wrong over some boxes is wrong over all: bounds get only wider.
                if counted.boxes < len(proven.boxes) and (
                    refused or not counted.all_hold or _any_refused(bounds.claims)
                ):
                    wrong = [claim for claim in bounds.claims if not claim.verified]
                    return [*chain.chain_claims(of, proven, counted), *wrong, *ends]
            return [*chain.chain_claims(of, proven, counted), *bounds.claims, *ends]
        except (np.linalg.LinAlgError, ValueError, OverflowError):
            text = "some numbers are too large, or give matrices without an inverse"
            return [Claim(f"{of}: its boxes can be evaluated", verified=False, found=text)]


def _any_refused(claims: list[Claim]) -> bool:
    return any(not claim.verified for claim in claims)


def _name(proven: ProvenChain) -> str:
    if _is_configured(proven):
        return _CONFIGURED
    uncertainty, profile, kept = proven.uncertainty, proven.profile_m, ", limits kept" if proven.within_limits else ""
    if uncertainty.ellipsoid is not None:
        return f"machines within {uncertainty.ellipsoid.sigma:g} deviations of the calibration{kept}"
    lengths, coordinates = 1e3 * uncertainty.length_m, 1e3 * uncertainty.coordinate_m
    parts = [f"lengths ± {lengths:.4g}, coordinates ± {coordinates:.4g}"] if uncertainty.calibration else []
    if profile is not None:
        parts.append(f"all actuators ± {1e3 * min(profile):.4g} to {1e3 * max(profile):.4g} over s")
    elif any(off := uncertainty.actuator_m):
        parts.append(f"{', '.join(ACTUATORS)} ± {', '.join(f'{1e3 * error:.4g}' for error in off)}")
    return f"{'; '.join(parts)} mm{kept}"
