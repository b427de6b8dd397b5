"""A stored certificate held against its path and machine: which of its claims are verified, and which are not."""

from collections.abc import Callable, Iterator

import numpy as np

from pipeline.certify.limits import Limits
from pipeline.certify.recheck.claim import Claim
from pipeline.certify.recheck.inclusion import Boxes, Inclusions, build_boxes, holds, include
from pipeline.certify.recheck.limits import CLAIMS, bound_claims, end_claims
from pipeline.certify.recheck.splines import SPLINES, spline_claim
from pipeline.certify.recheck.statement import StatedTolerance, Statement
from pipeline.certify.result import ProvenChain, path_sha256
from pipeline.inclusion.uncertainty import CERTAIN, Uncertainty, of_everything, of_lengths
from pipeline.machine.geometry import Machine
from pipeline.refine.result import Path
from pipeline.route.regions.endpoints import Endpoint

PATH = "it is about this path"
PREMISES = "it is about this machine, limits, start and goal"
NOMINAL = "its first chain is of the configured machine"
LENGTHS = "the tolerance of link lengths has its chain"
EVERYTHING = "the tolerance of coordinates has its chain"

_CONFIGURED = "configured machine"
_REACH = "boxes reach from s = 0 to 1"
_ONE_POSE = "each holds one pose, regular"
_SAME_BRANCH = "neighbours share a branch"

MANDATORY = (
    PATH,
    PREMISES,
    SPLINES,
    NOMINAL,
    LENGTHS,
    EVERYTHING,
    *(f"{_CONFIGURED}: {what}" for what in (_REACH, _ONE_POSE, _SAME_BRANCH)),
    *CLAIMS,
)
"""What has to be verified of any certificate, whatever it holds."""


def verify(
    machine: Machine,
    path: Path,
    limits: Limits,
    ends: tuple[Endpoint, Endpoint],
    premises_sha256: str,
    stated: Statement,
) -> list[Claim]:
    """Verify every claim of a certificate, without searching for anything; those of `MANDATORY` in any case."""
    spoken_of, splines = path_sha256(path), spline_claim(path.spline)
    claims = [
        Claim(PATH, stated.path_sha256 == spoken_of, spoken_of[:12]),
        Claim(PREMISES, stated.premises_sha256 == premises_sha256, premises_sha256[:12]),
        splines,
        *_inventory(stated),
    ]
    # Along what is no function boxes say nothing.
    if splines.verified:
        for chain in stated.chains:
            claims += _proof(machine, path, limits, ends, stated, chain)
    known = {claim.what for claim in claims}
    return claims + [Claim(what, verified=False, found="not shown") for what in MANDATORY if what not in known]


def _inventory(stated: Statement) -> Iterator[Claim]:
    """Verify that there are the chains that are spoken of, and no others."""
    first, rest = stated.chains[:1], stated.chains[1:]
    boxes = len(first[0].boxes) if first else 0
    configured = [chain.uncertainty for chain in first] == [CERTAIN]
    yield Claim(NOMINAL, configured and boxes == stated.boxes, f"{boxes} boxes; stated {stated.boxes}")
    coordinates = [chain for chain in rest if chain.uncertainty.coordinate_m > 0.0]
    lengths = [chain for chain in rest if chain.uncertainty.coordinate_m == 0.0]
    yield _tolerance_claim(LENGTHS, stated.link_length, lengths, of_lengths)
    yield _tolerance_claim(EVERYTHING, stated.coordinates, coordinates, of_everything)


def _tolerance_claim(
    what: str, stated: StatedTolerance | None, chains: list[ProvenChain], kind: Callable[[float], Uncertainty]
) -> Claim:
    """Verify that a tolerance has exactly one chain of its kind; none where it is zero or not stated."""
    if stated is None:
        return Claim(what, not chains, f"none stated; {len(chains)} chains")
    proven = [(chain.uncertainty, len(chain.boxes)) for chain in chains]
    if stated.eps_m > 0.0:
        kept = proven == [(kind(stated.eps_m), stated.boxes)]
    else:
        kept = stated.eps_m == 0.0 and stated.boxes == 0 and not chains
    eps = ", ".join(f"{1e3 * max(u.length_m, u.coordinate_m):.6g} mm in {n} boxes" for u, n in proven) or "no chain"
    return Claim(what, kept, f"{eps}; stated {1e3 * stated.eps_m:.6g} mm in {stated.boxes}")


def _proof(
    machine: Machine, path: Path, limits: Limits, ends: tuple[Endpoint, Endpoint], stated: Statement, chain: ProvenChain
) -> list[Claim]:
    """Verify a chain; of the machine as configured also what is stated of it."""
    of = _CONFIGURED
    if (uncertainty := chain.uncertainty).any:
        lengths, coordinates = 1e3 * uncertainty.length_m, 1e3 * uncertainty.coordinate_m
        of = f"lengths ± {lengths:.4g}, coordinates ± {coordinates:.4g} mm"
    # Numbers that are none compare as false: what cannot be computed is not verified.
    with np.errstate(all="ignore"):
        try:
            boxes, joints = (build_boxes(machine, path, part) for part in (chain.boxes, chain.joints))
            found, met = (include(machine, part, uncertainty) for part in (boxes, joints))
            claims = [*_chain_claims(of, boxes, found, joints, met)]
            if not uncertainty.any:
                claims += bound_claims(machine, limits, stated.bounds, boxes, found)
                claims += end_claims(machine, stated.bounds, joints, met, ends)
        except (np.linalg.LinAlgError, ValueError, OverflowError):
            what = f"{of}: the numbers of its boxes are of use"
            return [Claim(what, verified=False, found="some are too large, or give matrices that have no inverse")]
    return claims


def _chain_claims(of: str, boxes: Boxes, found: Inclusions, joints: Boxes, met: Inclusions) -> Iterator[Claim]:
    n = len(boxes.first)
    whole = boxes.first[0] == 0.0 and boxes.last[-1] == 1.0 and bool((boxes.first[1:] == boxes.last[:-1]).all())
    within = bool((boxes.first < boxes.last).all())
    yield Claim(f"{of}: {_REACH}", whole and within, f"{n} boxes from {boxes.first[0]:g} to {boxes.last[-1]:g}")
    across = n - int(boxes.on_one_piece.sum())
    beyond = f"; {across} reach across a knot of the splines" if across else ""
    yield Claim(f"{of}: {_ONE_POSE}", bool(found.proven.all()), f"{int(found.proven.sum())} of {n}{beyond}")
    ends = np.append(boxes.first, boxes.last[-1])
    single = bool((joints.first == joints.last).all()) and np.array_equal(joints.first, ends)
    linked = holds(boxes, found, joints, met, at_end=False) & holds(boxes, found, joints, met, at_end=True)
    linked &= met.proven[1:] & met.proven[:-1]
    yield Claim(f"{of}: {_SAME_BRANCH}", single and bool(linked.all()), f"{int(linked.sum())} of {n}")
