"""A stored certificate checked against its path and configuration: which of its claims are verified."""

from collections.abc import Callable, Iterator

import numpy as np

from pipeline.certify.premises import premises_sha256
from pipeline.certify.recheck.arithmetic.chain import EvaluatedChain, evaluate_chain
from pipeline.certify.recheck.claims import chain, checks, inventory
from pipeline.certify.recheck.claims.claim import Claim
from pipeline.certify.recheck.claims.evidence import Evidence
from pipeline.certify.recheck.claims.splines import SPLINES, spline_claim
from pipeline.certify.recheck.statement import Statement
from pipeline.certify.result import ProvenChain, path_sha256
from pipeline.config import Config
from pipeline.inclusion.uncertainty import Uncertainty
from pipeline.machine.geometry import Machine
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
        *inventory.inventory_claims(stated),
    ]

    def bound_claims(evaluated: EvaluatedChain) -> Iterator[Claim]:
        return checks.bound_claims(Evidence(config, machine, ends, evaluated), stated.bounds)

    # Boxes say nothing about splines that are not a function.
    if splines.verified:
        for proven in stated.chains:
            claims += _chain_claims(machine, path, proven, bound_claims)
    known = {claim.what for claim in claims}
    return claims + [Claim(what, verified=False, found="missing") for what in MANDATORY if what not in known]


def _chain_claims(
    machine: Machine, path: Path, proven: ProvenChain, bound_claims: Callable[[EvaluatedChain], Iterator[Claim]]
) -> list[Claim]:
    """Verify a chain; for the configured machine also the bounds that are stated of it."""
    of = _name(proven.uncertainty)
    # NaN compares as false: what cannot be computed is not verified.
    with np.errstate(all="ignore"):
        try:
            evaluated = evaluate_chain(machine, path, proven)
            bounds = [] if proven.uncertainty.any else bound_claims(evaluated)
            return [*chain.chain_claims(of, evaluated), *bounds]
        except (np.linalg.LinAlgError, ValueError, OverflowError):
            found = "some numbers are too large, or give matrices without an inverse"
            return [Claim(f"{of}: its boxes can be evaluated", verified=False, found=found)]


def _name(uncertainty: Uncertainty) -> str:
    if not uncertainty.any:
        return _CONFIGURED
    lengths, coordinates = 1e3 * uncertainty.length_m, 1e3 * uncertainty.coordinate_m
    return f"lengths ± {lengths:.4g}, coordinates ± {coordinates:.4g} mm"
