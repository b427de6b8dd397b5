"""Bounds of forces and of the TCP's motion that hold at every instant of a motion, and at rest before and after it.

Over an interval of time a force is a polynomial: a(s(t)) sdd + b(s(t)) sd^2 + c(s(t)). Dry friction is sign(q') F where
an actuator certainly moves one way while s grows, and anything up to F where it may turn: there it may jump. Intervals
are halved while their bounds are farther than a little above the largest value attained, or above a limit, unless loads
are not known better than that.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from flint import arb, arb_poly, fmpq

from pipeline.arrays import BoolArray, FloatArray
from pipeline.inclusion.condition import above, below
from pipeline.inclusion.pieces import exact
from pipeline.machine.geometry import Machine
from pipeline.retime.proof.exact_motion import LawPiece, about
from pipeline.retime.proof.path_loads import BoxLoads
from pipeline.retime.proof.polynomials import enclosure, extremes, magnitude
from pipeline.retime.quantities import both_sides, quantity_named

NAMES = ("force", "link_force", "tcp_speed", "tcp_acceleration")
"""What is bounded, in the order of columns: five drives, six links, and the TCP twice."""
COLUMNS = {
    "force": slice(0, 5),
    "link_force": slice(5, 11),
    "tcp_speed": slice(11, 12),
    "tcp_acceleration": slice(12, 13),
}
_DRIVES, _FORCES, _WIDTH = 5, 11, 13
_SHARP = 0.02
"""How far a bound may be above the largest value attained, relatively."""
_ROOM = 2e-5
"""Attained at most this part below a limit, it is not proven to hold: other arithmetic needs some room to verify it."""
_FLOOR = 1e-3
"""Part of a limit, or newtons, m/s and m/s^2, below which no bound need be sharp."""
_LEAST_PART = fmpq(1, 2**10)
"""Part of a piece of the time law that is not halved any more."""
_STANDSTILL = arb(1e-6)
"""Path speed in 1/s that counts as standing still: where rounding turns s back, friction does not turn."""
_STILL = arb(1e-9)
"""Metres per unit of s that an actuator at rest moves by rounding."""
_NEAR = 0.98
"""Part of a limit from which on bounds are as sharp as they can be."""


@dataclass(frozen=True, eq=False)
class LoadUse:
    """The largest loads: parts of the limits, or SI units where there is none, a column per subject of `COLUMNS`.

    Attributes
    ----------
    units : (2, 13)
        What positive and negative values are divided by: the limits, or one where neither has any.
    known, limited : (13,)
        Whether it is bounded, and whether its unit is a limit: forces need masses.
    proven, attained : (13,)
        No instant uses more; some instant uses as much.
    rest : (13,)
        What of the proven use is left however slow the motion: gravity and friction, there.
    t_s, s : (13,)
        Where the largest bound is: seconds since the beginning of the motion, and path parameter.
    intervals : int
        Intervals of time that prove it.
    """

    units: FloatArray
    known: BoolArray
    limited: BoolArray
    proven: FloatArray
    attained: FloatArray
    rest: FloatArray
    t_s: FloatArray
    s: FloatArray
    intervals: int

    @property
    def fractions(self) -> dict[str, FloatArray]:
        """Proven parts of the limits (subjects,), by name."""
        used = np.where(self.limited, self.proven, 0.0)
        return {name: used[part] for name, part in COLUMNS.items() if (self.known & self.limited)[part].any()}

    @property
    def peaks(self) -> dict[str, FloatArray]:
        """Proven bounds of magnitudes (subjects,) in SI units, by name; of forces with masses only."""
        peaks = self.proven * self.units.max(axis=0)
        return {name: peaks[part] for name, part in COLUMNS.items() if self.known[part].all()}

    @property
    def stretch(self) -> float:
        """Least factor, at least one, by which time has to be stretched for all limits to be proven.

        Forces at rest stay, those of motion fall with the square of the factor: see `moving_shares`.
        """
        over, powers = self.limited & self.known & (self.proven > 1.0), np.full(_WIDTH, 0.5)
        powers[COLUMNS["tcp_speed"]] = 1.0
        proven, rest = self.proven[over], self.rest[over]
        with np.errstate(divide="ignore"):
            factors = (((1.0 + 2.0 * _ROOM) * proven - rest) / np.maximum(1.0 - rest, 0.0)) ** powers[over]
        return float(max([1.0, *factors.tolist()]))


@dataclass(frozen=True, eq=False)
class _Interval:
    """An interval of time within a piece of the law, by its beginning and its end."""

    piece: LawPiece
    begins: fmpq
    ends: fmpq


@dataclass(frozen=True, eq=False)
class _Scale:
    """What loads are divided by (2, 13), the friction of the drives (5,) in newtons, and a factor of all bounds."""

    units: FloatArray
    friction: list[arb]
    wider: float


def load_use(law: Sequence[LawPiece], loads: list[BoxLoads], machine: Machine, *, wider: float = 1.0) -> LoadUse:
    """Bound the loads of a time law along a path whose loads are known box by box; all bounds by a factor `wider`."""
    limits = np.concatenate([both_sides(quantity_named(name).limit(machine)) for name in NAMES], axis=1)
    known, limited = np.arange(_WIDTH) >= (0 if machine.masses else _FORCES), np.isfinite(limits).any(axis=0)
    friction = [0.0] * _DRIVES if machine.masses is None else machine.masses.friction_n.tolist()
    scale = _Scale(np.where(limited, limits, 1.0), [arb(value) for value in friction], wider)
    firsts = [one.box.interval[0] for one in loads]
    proven, attained = (np.where(known, part, 0.0) for part in _at_rest(loads, scale))
    rest, t_s, s = proven, np.zeros(_WIDTH), np.zeros(_WIDTH)
    waiting, count = [_Interval(piece, fmpq(0), piece.length) for piece in law], 0
    while waiting:
        found = [_bound(_met(interval, loads, firsts), interval, scale) for interval in waiting]
        attained = np.maximum(attained, np.max([use.attained for use in found], axis=0))
        goal, halved = goals(attained, limited), list[_Interval]()
        for interval, use in zip(waiting, found, strict=True):
            good = np.maximum(goal, (1.0 + _ROOM) * use.least)
            if (use.bound > good).any() and interval.ends - interval.begins > _LEAST_PART * interval.piece.length:
                halved += _halves(interval)
                continue
            larger = use.bound > proven
            t_s, s, rest = (np.where(larger, new, old) for new, old in ((use.t_s, t_s), (use.s, s), (use.rest, rest)))
            proven, count = np.where(larger, use.bound, proven), count + 1
        waiting = halved
    proven = np.where(known, np.maximum(proven, goals(attained, limited)), 0.0)
    return LoadUse(scale.units, known, limited, proven, attained, rest, t_s, s, count)


def goals(attained: FloatArray, limited: BoolArray) -> FloatArray:
    """Give bounds that are good enough for the largest values attained: the limit, wherever that is still above."""
    near = limited & (attained > _NEAR)
    sharp = np.maximum((1.0 + np.where(near, _ROOM, _SHARP)) * attained, _FLOOR)
    return np.where(near & (attained <= 1.0 - _ROOM), 1.0, np.where(limited & ~near, np.minimum(sharp, 1.0), sharp))


def _halves(interval: _Interval) -> Iterator[_Interval]:
    middle = (interval.begins + interval.ends) / 2
    yield _Interval(interval.piece, interval.begins, middle)
    yield _Interval(interval.piece, middle, interval.ends)


def _met(interval: _Interval, loads: list[BoxLoads], firsts: list[float]) -> list[BoxLoads]:
    """Select the boxes that hold some s of an interval of time; s beyond the ends of the path counts as the ends."""
    middle, half = (interval.begins + interval.ends) / 2, arb((interval.ends - interval.begins) / 2)
    s = enclosure(about(interval.piece, middle), half)
    first, last = (max(int(np.searchsorted(firsts, end, side="right")) - 1, 0) for end in (below(s), above(s)))
    return loads[first : last + 1]


@dataclass(frozen=True, eq=False)
class _Use:
    """The use over an interval (13,): a bound, what its middle attains at t and s, and what of that is left at rest.

    No bound is below `least`, however short the interval: loads are known to some precision only.
    """

    bound: FloatArray
    least: FloatArray
    attained: FloatArray
    rest: FloatArray
    t_s: float
    s: float


def _bound(met: list[BoxLoads], interval: _Interval, scale: _Scale) -> _Use:
    """Bound the use over an interval of time by the boxes met."""
    middle, half = (interval.begins + interval.ends) / 2, arb((interval.ends - interval.begins) / 2)
    s = about(interval.piece, middle)
    bound, least, attained, rest = (np.zeros(_WIDTH) for _ in range(4))
    for one in met:
        signs, still = _directions(one, s, half), s - arb(exact(one.box.centre))
        forces, tcp = _over_time(one, s)
        for k, force in enumerate(forces):
            low, high = extremes(force, half)
            value, held = force(arb(0)), one.forces[k][2](still(arb(0)))
            if k < _DRIVES:
                friction = scale.friction[k]
                low, high = low + signs[k].lower() * friction, high + signs[k].upper() * friction
                value, held = value + signs[k] * friction, held + signs[k] * friction
            bound[k] = max(bound[k], _part(above(high), above(-low), scale.units[:, k]))
            least[k] = max(least[k], _part(above(value), above(-value), scale.units[:, k]))
            attained[k] = _part(below(value), below(-value), scale.units[:, k])
            rest[k] = max(rest[k], _part(above(held), above(-held), scale.units[:, k]))
        for k, vector in enumerate(tcp, start=_FORCES):
            sizes, values = [magnitude(part, half) for part in vector], [part(arb(0)).abs_lower() for part in vector]
            bound[k] = max(bound[k], _part(above(_norm(sizes)), -np.inf, scale.units[:, k]))
            attained[k] = _part(below(_norm(values)), -np.inf, scale.units[:, k])
    # Where several boxes are met, it is not known which holds the middle.
    attained = attained if len(met) == 1 else np.zeros(_WIDTH)
    return _Use(
        bound * scale.wider,
        least * scale.wider,
        attained,
        rest,
        interval.piece.begins + float(arb(middle).mid()),
        float(s(arb(0)).mid()),
    )


def _over_time(one: BoxLoads, s: arb_poly) -> tuple[list[arb_poly], list[list[arb_poly]]]:
    """Compose the loads of a box with s: forces (11 or 0), and velocity and acceleration of the TCP (2, 3), by time."""
    along, sd = s - arb(exact(one.box.centre)), s.derivative()
    sdd, squared = sd.derivative(), sd * sd
    forces = [a(along) * sdd + b(along) * squared + c(along) for a, b, c in one.forces]
    velocity = [first(along) * sd for first, _ in one.tcp]
    acceleration = [first(along) * sdd + second(along) * squared for first, second in one.tcp]
    return forces, [velocity, acceleration]


def _directions(one: BoxLoads, s: arb_poly, half: arb) -> list[arb]:
    """Give the signs of friction over an interval: 1 or -1, the ball of both where an actuator may turn, 0 at rest."""
    along = s - arb(exact(one.box.centre))
    way, signs = _sign(*extremes(s.derivative(), half), _STANDSTILL), []
    for row in one.box.piece.taylor(one.box.centre):
        low, high = extremes(arb_poly([arb(value) for value in row]).derivative()(along), half)
        still = low > -_STILL and high < _STILL
        signs.append(arb(0) if still else way * _sign(low, high, _STILL))
    return signs


def _sign(low: arb, high: arb, rounding: arb) -> arb:
    return arb(1) if low > -rounding else arb(-1) if high < rounding else arb(0, 1)


def _norm(values: list[arb]) -> arb:
    return sum((value * value for value in values), arb(0)).sqrt()


def _part(positive: float, negative: float, units: FloatArray) -> float:
    """Give the larger part of the limits of either side; infinite for what is no number."""
    part = max(positive / units[0], negative / units[1], 0.0)
    return np.inf if np.isnan(positive) or np.isnan(negative) else float(np.nextafter(part, np.inf))


def _at_rest(loads: list[BoxLoads], scale: _Scale) -> tuple[FloatArray, FloatArray]:
    """Bound what holds the machine at both ends of the path, where friction can only help, from above and below."""
    most, least = np.zeros(_WIDTH), np.zeros(_WIDTH)
    for one, s in ((loads[0], 0.0), (loads[-1], 1.0)):
        offset = arb(exact(s) - exact(one.box.centre))
        for k, (_, _, c) in enumerate(one.forces):
            value, units = c(offset), scale.units[:, k]
            most[k] = max(most[k], _part(above(value), above(-value), units))
            least[k] = max(least[k], _part(below(value), below(-value), units))
    return most, least
