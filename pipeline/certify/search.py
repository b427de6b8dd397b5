"""The largest errors with which a chain closes: at single s first, over the piece that bears least, then over all.

No box can be proven around an s at which not even that s can, so that most of the search is at single s. The chain is
then closed piece by piece. Where a piece bears less, the search goes on with that: what was proven stays so.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace

from pipeline.certify.chain import Chain, Examiner, accept_any, close_chain, close_over, join_chains, what_fails_at
from pipeline.certify.problem import Memory, ProofProblem
from pipeline.certify.reasons import NOT_VERIFIED, ProofFailure
from pipeline.certify.result import proven_chain
from pipeline.inclusion.pieces import Piece
from pipeline.inclusion.uncertainty import Uncertainty
from pipeline.progress import QUIET, Monitor

LEAST_M = 1e-7
"""Smaller errors are not tried."""
TIGHTENINGS, TIGHTER = 10, 0.99
"""How often, and to what, errors are made smaller for boxes that other arithmetic does not verify."""
_LEAST_POINTS, _RESOLUTION = 32, 0.02

Point = tuple[Piece, float]
"""A single s on a piece."""
_Attempt = Chain | ProofFailure | None
"""The chain that proves an error, if it is one of more than a single s; or where and why it is not proven."""


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
    resolution: float = _RESOLUTION

    def close(self, eps_m: float, pieces: Sequence[Piece] | None = None) -> Chain:
        """Close a chain for errors of a size, over some pieces or the whole path."""
        problem = replace(self.problem, uncertainty=self.kind(eps_m))
        return close_chain(problem, self.examine) if pieces is None else close_over(problem, pieces, self.examine)

    def failure_at(self, eps_m: float, point: Point) -> ProofFailure | None:
        """Say why errors of a size cannot be proven at a single s; None if they can."""
        problem = replace(self.problem, uncertainty=self.kind(eps_m))
        reason = what_fails_at(problem, *point, self.examine)
        return None if reason is None else ProofFailure(point[1], reason)

    def verifies(self, eps_m: float, chain: Chain) -> bool:
        """Return whether other arithmetic verifies a chain for errors of a size, if that is asked."""
        within_limits = self.examine is not accept_any
        ask = self.problem.verifies
        return ask is None or ask(proven_chain(chain, self.kind(eps_m), within_limits=within_limits))


@dataclass(frozen=True, eq=False)
class Bracket:
    """The largest error found to be proven, and the least found not to be.

    Attributes
    ----------
    proven_m, refuted_m : float
        Both errors.
    chain : Chain or None
        The proof of the first, if it is one of more than a single s.
    failure : ProofFailure or None
        Where and why the second is not proven.
    """

    proven_m: float
    refuted_m: float
    chain: Chain | None = None
    failure: ProofFailure | None = None

    def within(self, resolution: float) -> bool:
        """Return whether both are near each other, or nothing can be proven."""
        return self.refuted_m <= max((1.0 + resolution) * self.proven_m, LEAST_M)

    def below(self, other: "Bracket") -> "Bracket":
        """Take the failure of another bracket where that is at a smaller error."""
        if other.refuted_m >= self.refuted_m:
            return self
        return replace(self, refuted_m=other.refuted_m, failure=other.failure)


def new_search(
    problem: ProofProblem,
    kind: Callable[[float], Uncertainty],
    examine: Examiner = accept_any,
    resolution: float = _RESOLUTION,
) -> Search:
    """Begin a search that shares with others what does not depend on the errors."""
    memory = (problem.memory or Memory()).of_another_kind()
    return Search(replace(problem, memory=memory), kind, examine, resolution)


def largest_error(search: Search, likely_m: float, likely_s: float, monitor: Monitor = QUIET) -> Bracket:
    """Bracket the largest error for which the whole chain closes, from a guess of it and of where it is decided."""
    monitor.progress("searching at single s")
    bracket, (decisive, _) = _largest_at_points(search, max(LEAST_M, likely_m), likely_s)
    if bracket.proven_m <= LEAST_M:
        return replace(bracket, proven_m=0.0)
    found = largest_over(search, decisive, bracket.proven_m).below(bracket)
    parts = list[tuple[Piece, Chain]]()
    for piece in search.problem.pieces:
        monitor.progress(f"closing the chain with an error of {1e3 * found.proven_m:.4g} mm", piece.first)
        local = largest_over(search, piece, found.proven_m)
        if local.chain is None:
            return replace(local, proven_m=0.0)
        parts.append((piece, local.chain))
        found = local.below(found)
    return _joined(search, parts, found)


def _joined(search: Search, parts: Sequence[tuple[Piece, Chain]], found: Bracket) -> Bracket:
    """Join the chains of all pieces, each proven for the errors found or larger ones; search on where that fails.

    Other arithmetic is asked to verify the chain: for errors that are a little smaller it is wider by less.
    """
    eps = found.proven_m
    for _ in range(TIGHTENINGS):
        chain = join_chains(replace(search.problem, uncertainty=search.kind(eps)), parts)
        if chain.failure is not None:
            break
        if search.verifies(eps, chain):
            return replace(found, proven_m=eps, chain=chain)
        eps *= TIGHTER

    def attempt(eps: float) -> _Attempt:
        chain = search.close(eps)
        return _proven(chain) if chain.failure or search.verifies(eps, chain) else ProofFailure(0.0, NOT_VERIFIED)

    start = Bracket(0.0, found.proven_m, None, chain.failure or ProofFailure(0.0, NOT_VERIFIED))
    return _narrowed(start, None, attempt, search.resolution)


def largest_over(search: Search, piece: Piece, most_m: float) -> Bracket:
    """Bracket the largest error over a piece, up to `most_m`: above it is refuted, or not asked."""
    if most_m <= LEAST_M:
        return Bracket(0.0, most_m)
    chain = search.close(most_m, [piece])
    if chain.failure is None:
        return Bracket(most_m, float("inf"), chain)
    start = Bracket(0.0, most_m, None, chain.failure)
    return _narrowed(start, None, lambda eps: _proven(search.close(eps, [piece])), search.resolution)


def _proven(chain: Chain) -> _Attempt:
    return chain if chain.failure is None else chain.failure


def _largest_at_points(search: Search, likely_m: float, likely_s: float) -> tuple[Bracket, Point]:
    """Bracket the largest error that every one of some single s bears, and say which of them bears least."""
    pieces = search.problem.pieces
    parts = -(-_LEAST_POINTS // len(pieces))
    points = [(pieces[0], pieces[0].first), *(point for piece in pieces for point in points_of(piece, parts))]
    points.sort(key=lambda point: abs(point[1] - likely_s))
    decisive = points[0]
    bracket = largest_at(search, decisive, Bracket(0.0, float("inf")), likely_m)
    for point in points[1:]:
        if bracket.proven_m <= LEAST_M:
            break
        if failure := search.failure_at(bracket.proven_m, point):
            decisive, bracket = point, largest_at(search, point, Bracket(0.0, bracket.proven_m, None, failure))
    return bracket, decisive


def largest_at(search: Search, point: Point, bracket: Bracket, likely_m: float | None = None) -> Bracket:
    """Bracket the largest error that a single s bears."""
    return _narrowed(bracket, likely_m, lambda eps: search.failure_at(eps, point), search.resolution)


def _narrowed(
    bracket: Bracket, first_m: float | None, attempt: Callable[[float], _Attempt], resolution: float
) -> Bracket:
    """Narrow a bracket: by growing steps up, or down, while only one side of it is known; then by bisection."""
    step, eps = resolution, first_m
    while not bracket.within(resolution):
        if eps is None:
            eps, step = _next(bracket, step), 2.0 * step
        found = attempt(eps)
        if isinstance(found, ProofFailure):
            bracket = replace(bracket, refuted_m=eps, failure=found)
        else:
            bracket = replace(bracket, proven_m=eps, chain=found)
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
