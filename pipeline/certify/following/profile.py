"""How large errors of all actuators may be over s: searched piece by piece, and proven as one chain."""

from collections.abc import Iterator
from dataclasses import replace

from pipeline.certify.chain import close_chain
from pipeline.certify.following.search import LEAST_M, Bracket, Point, Search, narrowed, piece_at, points_of
from pipeline.certify.result import ProvenChain, proven_chain
from pipeline.inclusion.pieces import Piece
from pipeline.progress import QUIET, Monitor

_LESS = 0.96
"""By how much less is tried over a piece than its single s bear, and where the chain does not close."""
_RESOLUTION = 0.05
_MOST_ATTEMPTS = 200


def prove_profile(
    search: Search, likely_m: float, *, within_limits: bool, monitor: Monitor = QUIET
) -> ProvenChain | None:
    """Prove one chain whose errors are as large over each piece as was found; None if some piece bears none.

    At a joint both pieces have the smaller errors of the two, so that a motion that stays within those at every s is
    covered: for the pose is one continuous function of s and the errors.
    """
    pieces, profile = search.problem.pieces, dict[float, float]()
    for k, piece in enumerate(pieces):
        monitor.progress(f"profile: piece {k + 1} of {len(pieces)}", k / len(pieces))
        likely_m = _largest(search, piece, likely_m)
        if likely_m <= LEAST_M:
            return None
        profile[piece.first] = likely_m
    for _ in range(_MOST_ATTEMPTS):
        least = search.kind(min(profile.values()))
        chain = close_chain(replace(search.problem, uncertainty=least, profile_m=profile), search.examine)
        if chain.failure is None:
            errors = tuple(profile[piece_at(search.problem, proven.box.last).first] for proven in chain.inclusions)
            return replace(proven_chain(chain, least, within_limits=within_limits), profile_m=errors)
        profile[piece_at(search.problem, chain.failure.s).first] *= _LESS
    return None


def _largest(search: Search, piece: Piece, likely_m: float) -> float:
    """Find what a piece bears: a little less than its single s; zero if that is almost nothing."""
    eps = _at_points(search, points_of(piece, 2), likely_m)
    while eps > LEAST_M and search.close(eps, [piece]).failure is not None:
        eps *= _LESS
    return eps if eps > LEAST_M else 0.0


def _at_points(search: Search, points: Iterator[Point], likely_m: float) -> float:
    bracket = Bracket(0.0, float("inf"))
    for point in points:
        if bracket.proven_m == 0.0 or not search.bears(bracket.proven_m, point):
            bracket = narrowed(
                Bracket(0.0, bracket.proven_m or float("inf")),
                likely_m,
                lambda eps, at=point: search.bears(eps, at),  # type: ignore[misc]
                _RESOLUTION,
            )
            likely_m = bracket.proven_m
    return bracket.proven_m
