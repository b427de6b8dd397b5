"""The shortest motion with bounded jerk: guess, solve, check within pieces and solve again, until all limits hold."""

from dataclasses import dataclass, replace

import numpy as np

from pipeline.arrays import BoolArray, FloatArray
from pipeline.errors import NoSolutionError
from pipeline.progress import QUIET, Monitor
from pipeline.retime.jerk.first_guess import first_guess
from pipeline.retime.jerk.options import DEFAULTS, JerkOptions
from pipeline.retime.jerk.program import Checks, build_program, solve_program
from pipeline.retime.jerk.quartic_law import QuarticLaw, halved, slowed
from pipeline.retime.path_dynamics import PathDynamicsTable
from pipeline.retime.quantities import evaluate, fractions, limited, limits, moving_shares
from pipeline.retime.result import Trajectory
from pipeline.solvers import interrupts_noted

_PARTS = np.arange(1, 20) / 20.0
"""Where within a piece limits are evaluated between two solves."""
_HELD = 1.0005
"""Largest fraction that needs no further round; stretching time removes the rest."""
_CHECKED = 1.0002
"""Fraction from which on a point is checked in the next round."""
_HALVED = 1.01
"""Fraction from which on, after the first round, a piece and its neighbours are halved."""
_SETTLED = 1e-3
"""Least relative gain in time that is worth another round: in each, seconds change within bounds only."""
_STILL = 0.01
"""Least acceleration of an actuator, relative to that of the fastest one, by which its jerk is judged."""
_SOLVED = ("Solve_Succeeded", "Solved_To_Acceptable_Level")


@dataclass(frozen=True, eq=False)
class JerkLimited:
    """A trajectory with bounded jerk, and how it was found: its pieces, rounds and iterations."""

    trajectory: Trajectory
    pieces: int
    rounds: int
    iterations: int


def limit_jerk(
    table: PathDynamicsTable,
    fastest: Trajectory,
    pieces: int,
    monitor: Monitor = QUIET,
    options: JerkOptions = DEFAULTS,
) -> JerkLimited:
    """Find the shortest motion along the path under all limits, from rest to rest without acceleration at either end.

    Jerk limits so high that accelerations would build up within a tiny part of the motion are lowered (`most_ramps`).
    Limits hold at breakpoints and in the middle of every piece. After each solve they are evaluated in between; where
    they are exceeded, the next program checks them, and after the first solve pieces are halved there.

    Raises
    ------
    NoSolutionError
        When a program is not solved.
    """
    path, table = table.path, _resolved(table, fastest, options.most_ramps)
    law = first_guess(table, fastest, pieces, options.pieces_per_width)
    found = _in_rounds(table, law, monitor, options)
    return replace(found, trajectory=replace(found.trajectory, path=path))


def shorten(
    table: PathDynamicsTable, own: Trajectory, pieces: int, monitor: Monitor = QUIET, options: JerkOptions = DEFAULTS
) -> JerkLimited:
    """Shorten a motion s = t / T along a path that is at rest at both ends itself, on even breakpoints.

    Raises
    ------
    NoSolutionError
        When a program is not solved.
    """
    s, none = np.linspace(0.0, 1.0, pieces + 1), np.zeros(pieces + 1)
    motion_s = own.motion_s
    law = QuarticLaw(s, none + 1.0 / motion_s, none, none, np.full(pieces, motion_s / pieces))
    return _in_rounds(table, law, monitor, options)


def _in_rounds(table: PathDynamicsTable, law: QuarticLaw, monitor: Monitor, options: JerkOptions) -> JerkLimited:
    """Solve from a time law, check within pieces and solve again, until all limits hold.

    Raises
    ------
    NoSolutionError
        When the first program is not solved.
    """
    checks = _midpoints(law)
    iterations, before = 0, np.inf
    for number in range(options.rounds):
        try:
            law, took = _solve(table, law, checks, monitor, options)
        except NoSolutionError:
            if number == 0:
                raise
            # The last law is slowed down to keep what this round would have mended.
            break
        iterations += took
        largest, settled = _fractions(table, law), law.h.sum() > before * (1.0 - _SETTLED)
        if (largest.max() <= _HELD and settled) or iterations >= options.all_iterations:
            break
        before = law.h.sum()
        if number == 0 and largest.max() > _HALVED:
            law = halved(law, _with_neighbours(largest.max(axis=1) > _HALVED))
            checks = _midpoints(law)
        else:
            checks = _add_checks(checks, largest)
    trajectory = Trajectory(table.path, law.time_law())
    return JerkLimited(trajectory, len(law.h), number + 1, iterations)


def _resolved(table: PathDynamicsTable, fastest: Trajectory, most_ramps: float) -> PathDynamicsTable:
    """Lower jerk limits until accelerations take at least 1 / most_ramps of the motion to build up.

    The accelerations are those of the fastest motion, or what takes it to its velocities in that time.
    """
    law = fastest.time_law
    middle, least_s = fastest.dwell_s[0] + (law.x[1:] + law.x[:-1]) / 2.0, fastest.motion_s / most_ramps
    velocity, acceleration = (np.abs(fastest.q(middle, order)).max(axis=0) for order in (1, 2))
    used = np.minimum(acceleration, velocity / least_s)
    machine = table.path.machine
    enough = np.maximum(used, _STILL * used.max()) / least_s
    machine = replace(
        machine, jerk_mps3=np.where(np.isfinite(machine.jerk_mps3), np.minimum(machine.jerk_mps3, enough), np.inf)
    )
    return replace(table, path=replace(table.path, machine=machine))


def _solve(
    table: PathDynamicsTable, law: QuarticLaw, checks: Checks, monitor: Monitor, options: JerkOptions
) -> tuple[QuarticLaw, int]:
    """Solve the program from a time law, or from a slower one, which leaves more room; counts iterations."""
    what, iterations = f"limiting jerk: {len(law.h)} pieces, {len(checks.piece)} checks within", 0
    monitor.progress(what)

    def report(iteration: int, _: float) -> None:
        monitor.progress(f"{what}, IPOPT iteration {iteration}")

    for slowdown in options.slowdowns:
        # CasADi's wrappers swallow exceptions raised while they convert arguments, and Ctrl-C is one.
        with interrupts_noted():
            program = build_program(table, slowed(law, slowdown), checks)
        found, status, took = solve_program(program, options.iterations, monitor.verbose, report)
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


def _midpoints(law: QuarticLaw) -> Checks:
    count = len(law.h)
    return Checks(np.arange(count), np.full(count, 0.5))


def _add_checks(checks: Checks, largest: FloatArray) -> Checks:
    """Add the point of the largest fraction in every piece where it is too large."""
    pieces = np.flatnonzero(largest.max(axis=1) > _CHECKED)
    parts = _PARTS[largest[pieces].argmax(axis=1)]
    return Checks(np.concatenate([checks.piece, pieces]), np.concatenate([checks.part, parts]))


def _fractions(table: PathDynamicsTable, law: QuarticLaw) -> FloatArray:
    """Evaluate the largest fraction of any limit at points within each piece. Shape (n, points)."""
    machine, count = table.path.machine, len(law.h)
    s, *state = law.state(np.repeat(np.arange(count), len(_PARTS)), np.tile(_PARTS, count))
    dynamics = table.at(s.clip(0.0, 1.0))
    values, allowed = evaluate(dynamics, *state), limits(machine)
    parts = [fractions(values[name], allowed[name]) for name in limited(machine)]
    # Where rest takes nearly all of a force, a small part of the limit is most of what is left for motion.
    parts += moving_shares(dynamics, values).values()
    return np.asarray(np.max([part.max(axis=1) for part in parts], axis=0).reshape(count, -1))


def _with_neighbours(pieces: BoolArray) -> BoolArray:
    grown = pieces.copy()
    grown[1:] |= pieces[:-1]
    grown[:-1] |= pieces[1:]
    return grown
