"""How much of every limit a trajectory uses, measured more densely than it was planned."""

from collections.abc import Iterator
from dataclasses import dataclass, field, fields, replace
from typing import Any

import numpy as np

from pipeline.arrays import FloatArray, IntArray
from pipeline.errors import NoSolutionError
from pipeline.retime.force_shares import moving_shares
from pipeline.retime.path_dynamics import TABLE_POINTS, Terms, TermsTable, table_of
from pipeline.retime.quantities import JERK, KINDS, kind_named, limited, limits
from pipeline.retime.result import Quality, Trajectory, TrajectorySamples

ALLOWED_USAGE = 1.001
"""Largest fraction of a limit that still counts as holding it: what a grid leaves open between its points."""
_AT_ONCE = 50_000
"""Instants looked at together."""
_PARTS = 10
"""Parts each piece of the time law, and each period, is divided into."""


@dataclass(frozen=True, eq=False)
class Usage:
    """Largest fraction of each limit that is used; None where there is no limit, or no way to tell.

    Attributes
    ----------
    velocity, acceleration, jerk, force : (5,)
        Of the actuators.
    link_force : (6,)
        Of the links, along their axes.
    tcp_speed, tcp_acceleration : (1,)
        Of the tool centre point.
    jerk_held : bool
        Jerk was to be limited; otherwise its usage tells what a controller sees, and is no limit to hold.
    force_stretch : float
        Least factor by which time has to be stretched for no force to be above its limit.
    peaks : mapping
        Largest magnitude of every quantity, in its own unit, whether or not it has a limit.
    """

    velocity: FloatArray
    acceleration: FloatArray
    jerk: FloatArray | None = None
    force: FloatArray | None = None
    link_force: FloatArray | None = None
    tcp_speed: FloatArray | None = None
    tcp_acceleration: FloatArray | None = None
    jerk_held: bool = True
    force_stretch: float = 1.0
    peaks: dict[str, FloatArray] = field(default_factory=dict)

    def held(self) -> dict[str, FloatArray]:
        """Fractions of all limits that are to be held, by name."""
        named = {kind.name: getattr(self, kind.name) for kind in KINDS}
        return {name: value for name, value in named.items() if value is not None and (name != JERK or self.jerk_held)}

    @property
    def largest(self) -> float:
        """The largest fraction of all limits that are to be held."""
        return float(max(value.max() for value in self.held().values()))

    @property
    def stretch(self) -> float:
        """Least factor (one or more) by which time has to be stretched for no fraction to be above one."""
        powers = {name: kind_named(name).power for name in self.held()}
        roots = (float(self.held()[name].max()) ** (1.0 / power) for name, power in powers.items() if power is not None)
        return float(max(1.0, self.force_stretch, *roots))


@dataclass(frozen=True, eq=False)
class TrajectoryFigures:
    """A sampled trajectory in numbers."""

    duration_s: float
    period_s: float
    samples: int
    usage: Usage
    quality: Quality | None = None
    dwell_s: tuple[float, float] = (0.0, 0.0)


@dataclass(frozen=True, eq=False)
class Course:
    """What happens at instants t (n,) of a trajectory: s (n,), every quantity (n, subjects) by its name, the terms."""

    t_s: FloatArray
    s: FloatArray
    values: dict[str, FloatArray]
    terms: Terms


def measure_trajectory(trajectory: Trajectory, samples: TrajectorySamples) -> TrajectoryFigures:
    """Reduce a trajectory and its samples to figures; limits are looked at between the samples, too."""
    return TrajectoryFigures(
        samples.duration_s,
        samples.period_s,
        len(samples),
        measure_usage(trajectory, samples.period_s),
        trajectory.quality,
        trajectory.dwell_s,
    )


def course(trajectory: Trajectory, period_s: float | None = None, table: TermsTable | None = None) -> Iterator[Course]:
    """Look at eleven points of every piece of the law, its two ends included, and at every tenth of a period.

    What jumps where two pieces meet is looked at on both sides. Where accelerations jump, the jerk is what a controller
    with this period sees: the change of the acceleration over a period, divided by it; without a period it is unknown.
    A long course comes in parts.
    """
    table = table_of(trajectory.path, TABLE_POINTS) if table is None else table
    piece, elapsed = _instants(trajectory, period_s)
    for first in range(0, len(piece), _AT_ONCE):
        part = slice(first, first + _AT_ONCE)
        yield _look(trajectory, table, piece[part], elapsed[part], period_s)


def _instants(trajectory: Trajectory, period_s: float | None) -> tuple[IntArray, FloatArray]:
    """Numbers of pieces and the seconds elapsed in them."""
    law, h = trajectory.time_law, np.diff(trajectory.time_law.x)
    elapsed = (h[:, None] * np.linspace(0.0, 1.0, _PARTS + 1)).ravel()
    piece = np.repeat(np.arange(len(h)), _PARTS + 1)
    if period_s is not None:
        t = np.arange(0.0, trajectory.motion_s, period_s / _PARTS)
        more = np.clip(np.searchsorted(law.x, t, side="right") - 1, 0, len(h) - 1)
        piece, elapsed = np.concatenate([piece, more]), np.concatenate([elapsed, t - law.x[more]])
    return piece, elapsed


def _look(
    trajectory: Trajectory, table: TermsTable, piece: IntArray, elapsed: FloatArray, period_s: float | None
) -> Course:
    law = trajectory.time_law
    s, sd, sdd, sddd = _law(law.c[:, piece], elapsed)
    s = s.clip(0.0, 1.0)
    terms = table.at(s)
    values = terms.values(sd, sdd, sddd)
    t = law.x[piece] + elapsed + trajectory.dwell_s[0]
    if trajectory.jerk_jumps:
        del values[JERK]
        if period_s is not None:
            values[JERK] = _seen_jerk(trajectory, t, values["acceleration"], period_s)
    return Course(t, s, values, terms)


def _seen_jerk(trajectory: Trajectory, t: FloatArray, acceleration: FloatArray, period_s: float) -> FloatArray:
    """Change of the acceleration over the period after t (n,), and over that before, while the motion begins.

    Before the motion the machine stands, so that no instant of it looks ahead over the jump it begins with.
    """
    change = np.abs(trajectory.q(t + period_s, 2) - acceleration)
    begins = (t < trajectory.dwell_s[0] + period_s)[:, None]
    jerk: FloatArray = np.maximum(change, np.where(begins, np.abs(acceleration), 0.0)) / period_s
    return jerk


def measure_usage(trajectory: Trajectory, period_s: float | None = None, table: TermsTable | None = None) -> Usage:
    """Measure the largest fraction of every limit, wherever `course` looks."""
    usage, *others = (_usage(trajectory, part) for part in course(trajectory, period_s, table))
    for other in others:
        usage = _larger(usage, other)
    return usage


def require_limits(
    trajectory: Trajectory, period_s: float | None = None, table: TermsTable | None = None, backwards: bool = False
) -> Usage:
    """Measure the usage and insist on it.

    Parameters
    ----------
    backwards : bool
        The trajectory is that of the way back: s is told along the way there.

    Raises
    ------
    NoSolutionError
        When a limit is exceeded by more than 0.1 %; names what exceeds it, the limit, the value and the place.
    """
    usage = measure_usage(trajectory, period_s, table)
    if usage.largest > ALLOWED_USAGE:
        parts = course(trajectory, period_s, table)
        raise _exceeded(trajectory, max(parts, key=lambda part: _usage(trajectory, part).largest), backwards)
    return usage


def _larger(one: Usage, other: Usage) -> Usage:
    """Take the larger of every fraction."""
    taken: dict[str, Any] = {}
    for name in (entry.name for entry in fields(Usage)):
        a, b = getattr(one, name), getattr(other, name)
        if isinstance(a, dict):
            taken[name] = {key: np.maximum(a[key], b[key]) for key in a}
        elif a is not None:
            taken[name] = np.maximum(a, b) if isinstance(a, np.ndarray) else max(a, b)
    return replace(one, **taken)


def _law(c: FloatArray, elapsed: FloatArray) -> list[FloatArray]:
    """s(t) and its first three derivatives, for coefficients (k, n) of pieces and the time elapsed in them (n,)."""
    found = []
    for _ in range(4):
        value = np.zeros_like(elapsed)
        for row in c:
            value = value * elapsed + row
        found.append(value)
        c = c[:-1] * np.arange(len(c) - 1, 0, -1)[:, None]
    return found


def _usage(trajectory: Trajectory, found: Course) -> Usage:
    machine = trajectory.path.machine
    allowed, names = limits(machine), limited(machine)
    peaks = {name: np.abs(values).max(axis=0) for name, values in found.values.items()}
    shares = moving_shares(found.terms, found.values)
    fractions = {name: peaks[name] / allowed[name] for name in names if name in peaks}
    return Usage(
        **fractions,
        jerk_held=not trajectory.jerk_jumps,
        force_stretch=float(np.sqrt(max((float(part.max()) for part in shares.values()), default=1.0))),
        peaks=peaks,
    )


def _exceeded(trajectory: Trajectory, found: Course, backwards: bool) -> NoSolutionError:
    usage = _usage(trajectory, found)
    name = max(usage.held(), key=lambda held: usage.held()[held].max())
    kind, allowed = kind_named(name), limits(trajectory.path.machine)[name]
    fractions = np.abs(found.values[name]) / allowed
    row, subject = np.unravel_index(np.argmax(fractions), fractions.shape)
    fraction, limit = float(fractions[row, subject]), float(allowed[subject])
    s, t = float(found.s[row]), float(found.t_s[row])
    s = 1.0 - s if backwards else s
    return NoSolutionError(
        "retime",
        f"{kind.subjects[subject]} would reach {fraction * limit:.4g} {kind.unit}, {fraction:.1%} of its {kind.words} "
        f"limit of {limit:g} {kind.unit}, between two points of the plan, at s = {s:.4f}, t = {t:.3f} s",
        "Ask for a smoother path: fewer refine.coefficients, or more refine.corridor_cells.",
        {"actuator": kind.subjects[subject], "limit": name, "fraction": fraction, "s": s, "t_s": t},
    )
