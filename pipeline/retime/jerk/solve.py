"""The shortest motion with bounded jerk: guess, solve, check within the pieces, refine, until all limits hold."""

from dataclasses import dataclass

import numpy as np

from pipeline.arrays import BoolArray, FloatArray
from pipeline.errors import NoSolutionError
from pipeline.progress import Progress, silent
from pipeline.retime.force_shares import moving_shares
from pipeline.retime.jerk.first_guess import first_guess
from pipeline.retime.jerk.law import Pieces, halved, slowed
from pipeline.retime.jerk.program import Checks, build_program, solve_program
from pipeline.retime.path_dynamics import TermsTable
from pipeline.retime.quantities import limited, limits
from pipeline.retime.result import Trajectory
from pipeline.solvers import interrupts_noted

_PARTS = np.arange(1, 20) / 20.0
"""Where within a piece limits are looked at between two solves."""
_HELD = 1.0005
"""Largest fraction that needs no further round; what it leaves is taken off by stretching time."""
_CHECKED = 1.0002
"""Fraction from which on a place is checked in the next round."""
_HALVED = 1.01
"""Fraction from which on, in the first round, a piece and its neighbours are halved."""
_SETTLED = 1e-3
"""Relative gain in time by a round from which on another one is worth it: seconds change within bounds in each."""
_ROUNDS = 12
_ITERATIONS = 500
_SLOWER = (1.0, 2.0, 5.0)
"""Factors by which the law before is slowed down, one after the other, until a program is solved from it."""
_SOLVED = ("Solve_Succeeded", "Solved_To_Acceptable_Level")


@dataclass(frozen=True, eq=False)
class JerkLimited:
    """A time law with bounded jerk, and what it took to find it."""

    trajectory: Trajectory
    pieces: int
    rounds: int
    iterations: int


def limit_jerk(
    table: TermsTable, fastest: Trajectory, pieces: int, progress: Progress = silent, verbose: bool = False
) -> JerkLimited:
    """Find the shortest motion along the path under all limits, from rest to rest without acceleration at either end.

    Limits hold at breakpoints and in the middle of every piece; after each solve they are looked at in between, and
    where they are exceeded there are points to check in the next. After the first solve pieces there are halved, too.

    Raises
    ------
    NoSolutionError
        When a program is not solved.
    """
    law = first_guess(table, fastest, pieces)
    checks = _middles(law)
    iterations, before = 0, np.inf
    for number in range(_ROUNDS):
        law, took = _solved(table, law, checks, progress, verbose)
        iterations += took
        largest, settled = _fractions(table, law), law.h.sum() > before * (1.0 - _SETTLED)
        if largest.max() <= _HELD and settled:
            break
        before = law.h.sum()
        if number == 0 and largest.max() > _HALVED:
            law = halved(law, _and_neighbours(largest.max(axis=1) > _HALVED))
            checks = _middles(law)
        else:
            checks = _more(checks, largest)
    trajectory = Trajectory(table.path, law.time_law())
    return JerkLimited(trajectory, len(law.h), number + 1, iterations)


def _solved(table: TermsTable, law: Pieces, checks: Checks, progress: Progress, verbose: bool) -> tuple[Pieces, int]:
    """Solve the program from a law, or from the same law slowed down, which leaves more room; counts iterations."""
    what, iterations = f"limiting jerk: {len(law.h)} pieces, {len(checks.piece)} checks within", 0
    progress(what)

    def tell(iteration: int, _: float) -> None:
        progress(f"{what}, IPOPT iteration {iteration}")

    for slower in _SLOWER:
        # CasADi's wrappers forget errors that come while they convert arguments, and Ctrl-C is one.
        with interrupts_noted():
            program = build_program(table, slowed(law, slower), checks)
        found, status, took = solve_program(program, _ITERATIONS, verbose, tell)
        iterations += took
        if status in _SOLVED:
            return found, iterations
    raise NoSolutionError(
        "retime",
        f"the motion with limited jerk did not converge ({status.replace('_', ' ').lower()}, "
        f"{iterations} iterations on {len(law.h)} pieces)",
        "Give other retime.jerk_pieces, or retime.jerk: off for a motion whose accelerations jump.",
        {"status": status, "pieces": len(law.h)},
    )


def _middles(law: Pieces) -> Checks:
    count = len(law.h)
    return Checks(np.arange(count), np.full(count, 0.5))


def _more(checks: Checks, largest: FloatArray) -> Checks:
    """Add the place of the largest fraction in every piece where it is too large."""
    pieces = np.flatnonzero(largest.max(axis=1) > _CHECKED)
    parts = _PARTS[largest[pieces].argmax(axis=1)]
    return Checks(np.concatenate([checks.piece, pieces]), np.concatenate([checks.part, parts]))


def _fractions(table: TermsTable, law: Pieces) -> FloatArray:
    """Largest fraction of any limit at places within each piece, of forces beside those at rest. Shape (n, places)."""
    machine, count = table.path.machine, len(law.h)
    s, *state = law.state(np.repeat(np.arange(count), len(_PARTS)), np.tile(_PARTS, count))
    terms = table.at(s.clip(0.0, 1.0))
    values, allowed = terms.values(*state), limits(machine)
    parts = [np.abs(values[name]) / allowed[name] for name in limited(machine)]
    # Where rest takes nearly all of a force, a small part of the limit is much of what is left for motion.
    parts += moving_shares(terms, values).values()
    found: FloatArray = np.max([part.max(axis=1) for part in parts], axis=0).reshape(count, -1)
    return found


def _and_neighbours(those: BoolArray) -> BoolArray:
    grown = those.copy()
    grown[1:] |= those[:-1]
    grown[:-1] |= those[1:]
    return grown
