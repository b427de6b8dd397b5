"""How large errors of all actuators may be over s: searched piece by piece, and proven as one chain."""

from dataclasses import replace

from pipeline.certify.chain import Chain, join_chains
from pipeline.certify.result import ProvenChain, proven_chain
from pipeline.certify.search import TIGHTENINGS, TIGHTER, Bracket, Search, largest_at, largest_over, points_of
from pipeline.inclusion.pieces import Piece
from pipeline.progress import QUIET, Monitor

_RESOLUTION = 0.05


def prove_profile(
    search: Search, likely_m: float, *, within_limits: bool, monitor: Monitor = QUIET
) -> ProvenChain | None:
    """Prove one chain whose errors are as large over each piece as was found; None if some piece bears none.

    At a joint both pieces have the smaller errors of the two, so that a motion that stays within those at every s is
    covered: for the pose is one continuous function of s and the errors.
    """
    search = replace(search, resolution=_RESOLUTION)
    pieces, profile, parts = search.problem.pieces, dict[float, float](), list[tuple[Piece, Chain]]()
    for k, piece in enumerate(pieces):
        monitor.progress(f"profile: piece {k + 1} of {len(pieces)}", k / len(pieces))
        found = _largest(search, piece, likely_m)
        if found.chain is None:
            return None
        likely_m = profile[piece.first] = found.proven_m
        parts.append((piece, found.chain))
    for _ in range(TIGHTENINGS):
        least = search.kind(min(profile.values()))
        chain = join_chains(replace(search.problem, uncertainty=least, profile_m=profile), parts)
        if chain.failure is not None:
            return None
        errors = tuple(profile[piece.first] for piece, part in parts for _ in part.inclusions)
        proven = replace(proven_chain(chain, least, within_limits=within_limits), profile_m=errors)
        if search.problem.verifies is None or search.problem.verifies(proven):
            return proven
        profile = {first: TIGHTER * error for first, error in profile.items()}
    return None


def _largest(search: Search, piece: Piece, likely_m: float) -> Bracket:
    """Find what a piece bears: its single s first, as nothing around them bears more."""
    first, *others = points_of(piece, 2)
    bracket = largest_at(search, first, Bracket(0.0, float("inf")), likely_m)
    for point in others:
        if bracket.proven_m > 0.0 and search.failure_at(bracket.proven_m, point):
            bracket = largest_at(search, point, Bracket(0.0, bracket.proven_m))
    return largest_over(search, piece, bracket.proven_m)
