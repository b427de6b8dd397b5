"""The largest errors with which a chain closes: at single s first, over the piece that bears least, then over all.

No box can be proven around an s at which not even that s can, so that most of the search is at single s. The chain is
then closed piece by piece. Where a piece bears less, the search goes on with that: what was proven stays so.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace

from pipeline.certify.chain import Chain, Examiner, accept_any, bears, close_chain, close_over, join_chains
from pipeline.certify.problem import Memory, ProofProblem
from pipeline.inclusion.pieces import Piece
from pipeline.inclusion.uncertainty import Uncertainty
from pipeline.progress import QUIET, Monitor

LEAST_M = 1e-7
"""Smaller errors are not tried."""
_LEAST_POINTS = 32

Point = tuple[Piece, float]
"""A single s on a piece."""
_Attempt = tuple[bool, Chain | None]
"""Whether an error was proven, and the chain that proves it, if it is one of more than a single s."""


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


def new_search(
    problem: ProofProblem, kind: Callable[[float], Uncertainty], examine: Examiner, resolution: float
) -> Search:
    """Begin a search that shares with others what does not depend on the errors."""
    memory = (problem.memory or Memory()).of_another_kind()
    return Search(replace(problem, memory=memory), kind, examine, resolution)


def largest_error(search: Search, likely_m: float, likely_s: float, monitor: Monitor = QUIET) -> Bracket:
    """Bracket the largest error for which the whole chain closes, from a guess of it and of where it is decided."""
    monitor.progress("searching at single s")
    bracket, (decisive, _) = _largest_at_points(search, max(LEAST_M, likely_m), likely_s)
    if bracket.proven_m <= LEAST_M:
        return Bracket(0.0, bracket.refuted_m)
    found = largest_over(search, decisive, bracket.proven_m)
    found = Bracket(found.proven_m, min(found.refuted_m, bracket.refuted_m))
    parts = list[tuple[Piece, Chain]]()
    for piece in search.problem.pieces:
        monitor.progress(f"closing the chain with an error of {1e3 * found.proven_m:.4g} mm", piece.first)
        local = largest_over(search, piece, found.proven_m)
        if local.chain is None:
            return Bracket(0.0, local.refuted_m)
        parts.append((piece, local.chain))
        found = Bracket(local.proven_m, min(found.refuted_m, local.refuted_m))
    return _joined(search, parts, found)


def _joined(search: Search, parts: Sequence[tuple[Piece, Chain]], found: Bracket) -> Bracket:
    """Join the chains of all pieces, each proven for the errors found or larger ones; search on where that fails."""
    problem = replace(search.problem, uncertainty=search.kind(found.proven_m))
    chain = join_chains(problem, parts)
    if chain.failure is None:
        return replace(found, chain=chain)
    whole = _narrowed(Bracket(0.0, found.proven_m), None, lambda eps: _proven(search.close(eps)), search.resolution)
    return replace(whole, refuted_m=min(whole.refuted_m, found.refuted_m))


def largest_over(search: Search, piece: Piece, most_m: float) -> Bracket:
    """Bracket the largest error over a piece, up to `most_m`: above it is refuted, or not asked."""
    if most_m <= LEAST_M:
        return Bracket(0.0, most_m)
    chain = search.close(most_m, [piece])
    if chain.failure is None:
        return Bracket(most_m, float("inf"), chain)
    return _narrowed(Bracket(0.0, most_m), None, lambda eps: _proven(search.close(eps, [piece])), search.resolution)


def _proven(chain: Chain) -> _Attempt:
    return chain.failure is None, chain


def _largest_at_points(search: Search, likely_m: float, likely_s: float) -> tuple[Bracket, Point]:
    """Bracket the largest error that every one of some single s bears, and say which of them bears least."""
    pieces = search.problem.pieces
    parts = -(-_LEAST_POINTS // len(pieces))
    points = [(pieces[0], pieces[0].first), *(point for piece in pieces for point in points_of(piece, parts))]
    points.sort(key=lambda point: abs(point[1] - likely_s))
    decisive = points[0]
    bracket = largest_at(search, decisive, Bracket(0.0, float("inf")), likely_m)
    for point in points[1:]:
        if bracket.proven_m > LEAST_M and not search.bears(bracket.proven_m, point):
            decisive, bracket = point, largest_at(search, point, Bracket(0.0, bracket.proven_m))
    return bracket, decisive


def largest_at(search: Search, point: Point, bracket: Bracket, likely_m: float | None = None) -> Bracket:
    """Bracket the largest error that a single s bears."""
    return _narrowed(bracket, likely_m, lambda eps: (search.bears(eps, point), None), search.resolution)


def _narrowed(
    bracket: Bracket, first_m: float | None, attempt: Callable[[float], _Attempt], resolution: float
) -> Bracket:
    """Narrow a bracket: by growing steps up, or down, while only one side of it is known; then by bisection."""
    step, eps = resolution, first_m
    while not bracket.within(resolution):
        if eps is None:
            eps, step = _next(bracket, step), 2.0 * step
        proven, chain = attempt(eps)
        bracket = Bracket(eps, bracket.refuted_m, chain) if proven else replace(bracket, refuted_m=eps)
        eps = None
    return bracket


def _next(bracket: Bracket, step: float) -> float:
    """Give the next error to try."""
    if bracket.refuted_m == float("inf"):
        return max(LEAST_M, bracket.proven_m * (1.0 + 4.0 * step))
    if bracket.proven_m == 0.0:
        return bracket.refuted_m / (1.0 + step)
    return (bracket.proven_m + bracket.refuted_m) / 2.0


def points_of(piece: Piece, parts: int) -> Iterator[Point]:
    """Give single s that divide a piece into equal parts, the last one its end."""
    for k in range(1, parts):
        yield piece, piece.first + (piece.last - piece.first) * k / parts
    yield piece, piece.last
