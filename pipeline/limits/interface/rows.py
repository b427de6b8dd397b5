"""Rows that a limit adds to the nonlinear program of stage two, and unknowns of its own."""

from dataclasses import dataclass

import casadi as ca

from pipeline.arrays import FloatArray
from pipeline.machine.samples import PoseSamples


@dataclass(frozen=True, eq=False)
class Nodes:
    """The collocation nodes of a program.

    Attributes
    ----------
    pose, q : (6, k), (5, k)
        Poses and actuator positions as unknowns.
    guess : PoseSamples
        The k nodes at the initial guess. The first and the last are given and keep what they have.
    directions : (k, 5)
        Signs of the actuators' velocities at the guess; zero for one that stands still.
    clearance_margin_m : float
        `refine.clearance_margin_m`, kept on top of distances.
    reach_m : float
        Only what comes within this distance of its limit at the guess gets a row.
    """

    pose: ca.MX
    q: ca.MX
    guess: PoseSamples
    directions: FloatArray
    clearance_margin_m: float
    reach_m: float


@dataclass(frozen=True, eq=False)
class Unknowns:
    """Unknowns of a limit's own: the symbol, its initial guess and its bounds, all of the symbol's shape transposed."""

    symbol: ca.MX
    guess: FloatArray
    low: FloatArray
    high: FloatArray


@dataclass(frozen=True, eq=False)
class Row:
    """A named group of constraints low <= expression <= high."""

    name: str
    expression: ca.MX
    low: float
    high: float


@dataclass(frozen=True, eq=False)
class ProgramPart:
    """What a limit adds to the program."""

    unknowns: tuple[Unknowns, ...]
    rows: tuple[Row, ...]
