"""The largest errors with which a chain closes: at single s first, over the piece that bears least, then proven whole.

A chain closes if all its pieces do, and no box can be proven around an s at which not even that s can. So most of the
search is at single s; whole chains are tried only with what everything tried before bears.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace

from pipeline.certify.chain import Chain, Examiner, accept_any, bears, close_chain, close_over
from pipeline.certify.problem import Memory, ProofProblem
from pipeline.inclusion.pieces import Piece
from pipeline.inclusion.uncertainty import Uncertainty
from pipeline.progress import QUIET, Monitor

LEAST_M = 1e-7
"""Smaller errors are not tried."""
_LEAST_POINTS = 64

Point = tuple[Piece, float]
"""A single s on a piece."""


@dataclass(frozen=True, eq=False)
class Search:
    """A search for the largest errors of one kind.

    Attributes
    ----------
    problem : ProofProblem
        The path, with a memory.
    kind : callable
        Gives the uncertainty of a size.
    examine : callable
        What every box has to keep.
    resolution : float
        How finely the size is bracketed, relatively.
    """

    problem: ProofProblem
    kind: Callable[[float], Uncertainty]
    examine: Examiner = accept_any
    resolution: float = 0.02

    def close(self, eps_m: float, pieces: Sequence[Piece] | None = None) -> Chain:
        """Close a chain for errors of a size, over some pieces or the whole path."""
        problem = replace(self.problem, uncertainty=self.kind(eps_m))
        return close_chain(problem, self.examine) if pieces is None else close_over(problem, pieces, self.examine)

    def bears(self, eps_m: float, point: Point) -> bool:
        """Return whether errors of a size can be proven at a single s."""
        problem = replace(self.problem, uncertainty=self.kind(eps_m))
        return bears(problem, *point, self.examine)


@dataclass(frozen=True, eq=False)
class Bracket:
    """The largest error found to be proven, the least found not to be, and the chain of the first, if there is one."""

    proven_m: float
    refuted_m: float
    chain: Chain | None = None

    def within(self, resolution: float) -> bool:
        """Return whether both are near each other, or nothing can be proven."""
        return self.refuted_m <= max((1.0 + resolution) * self.proven_m, LEAST_M)

    def next_m(self) -> float:
        """Double what is proven, or bisect."""
        return 2.0 * self.proven_m if self.refuted_m == float("inf") else (self.proven_m + self.refuted_m) / 2.0


def new_search(
    problem: ProofProblem, kind: Callable[[float], Uncertainty], examine: Examiner, resolution: float
) -> Search:
    """Begin a search that shares with others what does not depend on the errors."""
    memory = (problem.memory or Memory()).of_another_kind()
    return Search(replace(problem, memory=memory), kind, examine, resolution)


def largest_error(search: Search, likely_m: float, likely_s: float, monitor: Monitor = QUIET) -> Bracket:
    """Bracket the largest error for which the whole chain closes, from a guess of it and of where it is decided."""
    monitor.progress("searching at single s")
    bracket, point = _largest_at_points(search, likely_m, likely_s)
    if bracket.proven_m <= LEAST_M:
        return bracket
    found, eps, piece = Bracket(0.0, bracket.refuted_m), bracket.proven_m, point[0]
    local = largest_over(search, piece, found, eps)
    found, eps = replace(found, refuted_m=local.refuted_m), local.proven_m
    while not found.within(search.resolution):
        monitor.progress(f"trying an error of {1e3 * eps:.4g} mm")
        chain = search.close(eps)
        if chain.failure is None:
            found = Bracket(eps, found.refuted_m, chain)
            eps = found.next_m()
            continue
        piece = piece_at(search.problem, chain.failure.s)
        local = largest_over(search, piece, Bracket(found.proven_m, eps))
        found = replace(found, refuted_m=local.refuted_m)
        eps = local.proven_m if local.proven_m > found.proven_m else found.next_m()
    return found


def largest_over(search: Search, piece: Piece, bracket: Bracket, first_m: float | None = None) -> Bracket:
    """Bracket the largest error over a piece, within a bracket that is proven at its least."""
    return narrowed(bracket, first_m, lambda eps: search.close(eps, [piece]).failure is None, search.resolution)


def _largest_at_points(search: Search, likely_m: float, likely_s: float) -> tuple[Bracket, Point]:
    """Bracket the largest error that every one of some single s bears, and say which of them bears least."""
    pieces = search.problem.pieces
    parts = max(2, -(-_LEAST_POINTS // len(pieces)))
    points = [(pieces[0], pieces[0].first), *(point for piece in pieces for point in points_of(piece, parts))]
    points.sort(key=lambda point: abs(point[1] - likely_s))
    decisive = points[0]
    bracket = _at(search, decisive, Bracket(0.0, float("inf")), likely_m)
    for point in points[1:]:
        if bracket.proven_m > LEAST_M and not search.bears(bracket.proven_m, point):
            decisive = point
            bracket = _at(search, point, Bracket(0.0, bracket.proven_m), 0.8 * bracket.proven_m)
    return bracket, decisive


def _at(search: Search, point: Point, bracket: Bracket, first_m: float) -> Bracket:
    return narrowed(bracket, first_m, lambda eps: search.bears(eps, point), search.resolution)


def narrowed(bracket: Bracket, first_m: float | None, proves: Callable[[float], bool], resolution: float) -> Bracket:
    """Narrow a bracket to a resolution: doubled as long as nothing fails, then bisected."""
    eps = bracket.next_m() if first_m is None else first_m
    while not bracket.within(resolution):
        bracket = replace(bracket, proven_m=eps) if proves(eps) else replace(bracket, refuted_m=eps)
        eps = bracket.next_m()
    return bracket


def points_of(piece: Piece, parts: int) -> Iterator[Point]:
    """Give single s that divide a piece into equal parts, the last one its end."""
    for k in range(1, parts):
        yield piece, piece.first + (piece.last - piece.first) * k / parts
    yield piece, piece.last


def piece_at(problem: ProofProblem, s: float) -> Piece:
    """Give the piece of the path that holds s."""
    return next(piece for piece in problem.pieces if s <= piece.last)
