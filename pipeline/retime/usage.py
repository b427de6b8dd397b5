"""The fraction of every limit that a trajectory uses, measured more densely than it was planned."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from pipeline.arrays import FloatArray, IntArray
from pipeline.errors import NoSolutionError
from pipeline.retime.path_dynamics import TABLE_POINTS, PathDynamics, PathDynamicsTable, dynamics_table
from pipeline.retime.quantities import (
    JERK,
    QUANTITIES,
    Quantities,
    evaluate,
    fractions,
    limited,
    limits,
    moving_shares,
    quantity_named,
)
from pipeline.retime.result import TimingReport, Trajectory, TrajectorySamples

ALLOWED_USAGE = 1.001
"""Largest fraction of a limit that still counts as within it: what a grid leaves open between its points."""
_BATCH = 50_000
"""Instants evaluated at a time."""
_PARTS = 10
"""Parts that every piece of the time law, and every period, is divided into."""


@dataclass(frozen=True, eq=False)
class Usage:
    """Largest fraction of each limit that a trajectory uses.

    Attributes
    ----------
    fractions : mapping
        Fractions (subjects,) by the names of the quantities; only of those that have a limit and can be computed.
    peaks : mapping
        Largest magnitudes (subjects,) by the names of the quantities, in their own units, with or without a limit.
    jerk_held : bool
        Jerk was limited; otherwise its fraction only reports what a controller sees.
    force_stretch : float
        Least factor by which time has to be stretched for all forces to be within their limits.
    quantities : tuple of Quantity
        What was measured, in the order of results.
    """

    fractions: Mapping[str, FloatArray]
    peaks: Mapping[str, FloatArray] = field(default_factory=dict)
    jerk_held: bool = True
    force_stretch: float = 1.0
    quantities: Quantities = QUANTITIES

    def held(self) -> dict[str, FloatArray]:
        """Select the fractions of all limits that have to hold, by name, in the order of the quantities."""
        names = (quantity.name for quantity in self.quantities if quantity.name != JERK or self.jerk_held)
        return {name: self.fractions[name] for name in names if name in self.fractions}

    @property
    def largest(self) -> float:
        """The largest fraction of all limits that have to hold."""
        return float(max(fraction.max() for fraction in self.held().values()))

    @property
    def stretch(self) -> float:
        """Least factor (at least one) by which time has to be stretched for no fraction to exceed one."""
        held = self.held()
        roots = (
            float(held[quantity.name].max()) ** (1.0 / quantity.power)
            for quantity in self.quantities
            if quantity.name in held and quantity.power is not None
        )
        return float(max(1.0, self.force_stretch, *roots))


@dataclass(frozen=True, eq=False)
class TrajectoryFigures:
    """A sampled trajectory in numbers."""

    duration_s: float
    period_s: float
    samples: int
    usage: Usage
    timing: TimingReport | None = None
    dwell_s: tuple[float, float] = (0.0, 0.0)


@dataclass(frozen=True, eq=False)
class MotionSamples:
    """A trajectory at n instants.

    Attributes
    ----------
    t_s, s : (n,)
        Time since the start, path parameter.
    values : mapping
        Quantities (n, subjects) by name.
    dynamics : PathDynamics
        The path dynamics there.
    """

    t_s: FloatArray
    s: FloatArray
    values: dict[str, FloatArray]
    dynamics: PathDynamics


def measure_trajectory(trajectory: Trajectory, samples: TrajectorySamples) -> TrajectoryFigures:
    """Reduce a trajectory and its samples to figures; the usage of limits is measured between samples, too."""
    return TrajectoryFigures(
        samples.duration_s,
        samples.period_s,
        len(samples),
        measure_usage(trajectory, samples.period_s),
        trajectory.timing,
        trajectory.dwell_s,
    )


def sample_motion(
    trajectory: Trajectory,
    period_s: float | None = None,
    table: PathDynamicsTable | None = None,
    quantities: Quantities = QUANTITIES,
) -> Iterator[MotionSamples]:
    """Evaluate all quantities at eleven points of every piece of the time law, and at every tenth of a period.

    Both ends of each piece are included, so that what jumps between two pieces is evaluated on both sides. Where
    accelerations jump, the jerk is what a controller with this period sees: the change of the acceleration over a
    period, divided by it; without a period it is unknown. Long motions come in batches.
    """
    table = dynamics_table(trajectory.path, TABLE_POINTS) if table is None else table
    piece, elapsed = _instants(trajectory, period_s)
    for first in range(0, len(piece), _BATCH):
        batch = slice(first, first + _BATCH)
        yield _evaluate(trajectory, table, (piece[batch], elapsed[batch]), period_s, quantities)


def _instants(trajectory: Trajectory, period_s: float | None) -> tuple[IntArray, FloatArray]:
    """Choose instants: the numbers of their pieces, and the seconds elapsed in them."""
    time_law, h = trajectory.time_law, np.diff(trajectory.time_law.x)
    elapsed = (h[:, None] * np.linspace(0.0, 1.0, _PARTS + 1)).ravel()
    piece = np.repeat(np.arange(len(h)), _PARTS + 1)
    if period_s is not None:
        t = np.arange(0.0, trajectory.motion_s, period_s / _PARTS)
        more = np.clip(np.searchsorted(time_law.x, t, side="right") - 1, 0, len(h) - 1)
        piece, elapsed = np.concatenate([piece, more]), np.concatenate([elapsed, t - time_law.x[more]])
    return piece, elapsed


def _evaluate(
    trajectory: Trajectory,
    table: PathDynamicsTable,
    instants: tuple[IntArray, FloatArray],
    period_s: float | None,
    quantities: Quantities,
) -> MotionSamples:
    """Evaluate all quantities at instants, given by piece (n,) and seconds elapsed in it (n,)."""
    time_law, (piece, elapsed) = trajectory.time_law, instants
    s, sd, sdd, sddd = _derivatives(time_law.c[:, piece], elapsed)
    s = s.clip(0.0, 1.0)
    dynamics = table.at(s)
    values = evaluate(dynamics, sd, sdd, sddd, quantities=quantities)
    t = time_law.x[piece] + elapsed + trajectory.dwell_s[0]
    if trajectory.jerk_jumps:
        values.pop(JERK, None)
        if period_s is not None:
            values[JERK] = _seen_jerk(trajectory, t, values["acceleration"], period_s)
    return MotionSamples(t, s, values, dynamics)


def _derivatives(c: FloatArray, elapsed: FloatArray) -> list[FloatArray]:
    """Evaluate s(t) and its first three derivatives, for coefficients (k, n) and the time elapsed in a piece (n,)."""
    results = []
    for _ in range(4):
        value = np.zeros_like(elapsed)
        for row in c:
            value = value * elapsed + row
        results.append(value)
        c = c[:-1] * np.arange(len(c) - 1, 0, -1)[:, None]
    return results


def _seen_jerk(trajectory: Trajectory, t: FloatArray, acceleration: FloatArray, period_s: float) -> FloatArray:
    """Compute the change of the acceleration over the period after t (n,), and from standstill at the beginning.

    The machine is at rest before the motion, so that no instant of it looks ahead over the jump it begins with.
    """
    change = np.abs(trajectory.q(t + period_s, 2) - acceleration)
    begins = (t < trajectory.dwell_s[0] + period_s)[:, None]
    return np.asarray(np.maximum(change, np.where(begins, np.abs(acceleration), 0.0)) / period_s)


def measure_usage(
    trajectory: Trajectory,
    period_s: float | None = None,
    table: PathDynamicsTable | None = None,
    quantities: Quantities = QUANTITIES,
) -> Usage:
    """Measure the largest fraction of every limit, at all instants of `sample_motion`."""
    usage, *others = (
        _usage(trajectory, part, quantities) for part in sample_motion(trajectory, period_s, table, quantities)
    )
    for other in others:
        usage = _larger(usage, other)
    return usage


def require_limits(
    trajectory: Trajectory,
    period_s: float | None = None,
    table: PathDynamicsTable | None = None,
    backwards: bool = False,
) -> Usage:
    """Measure the usage, and raise where a limit is exceeded.

    Parameters
    ----------
    backwards : bool
        The trajectory is the way back: s is reported along the way there.

    Raises
    ------
    NoSolutionError
        When a limit is exceeded by more than 0.1 %: names what exceeds it, the limit, the value and the place.
    """
    usage = measure_usage(trajectory, period_s, table)
    if usage.largest > ALLOWED_USAGE:
        batches = sample_motion(trajectory, period_s, table)
        worst = max(batches, key=lambda batch: _usage(trajectory, batch, usage.quantities).largest)
        raise _exceeded(trajectory, worst, backwards)
    return usage


def _larger(one: Usage, other: Usage) -> Usage:
    """Take the larger of all fractions and peaks."""
    return replace(
        one,
        fractions={name: np.maximum(value, other.fractions[name]) for name, value in one.fractions.items()},
        peaks={name: np.maximum(value, other.peaks[name]) for name, value in one.peaks.items()},
        force_stretch=max(one.force_stretch, other.force_stretch),
    )


def _usage(trajectory: Trajectory, motion: MotionSamples, quantities: Quantities) -> Usage:
    machine = trajectory.path.machine
    allowed, names = limits(machine, quantities), limited(machine, quantities)
    peaks = {name: np.abs(values).max(axis=0) for name, values in motion.values.items()}
    used = {name: fractions(motion.values[name], allowed[name]) for name in names if name in peaks}
    shares = moving_shares(motion.dynamics, motion.values, quantities)
    return Usage(
        fractions={name: values.max(axis=0) for name, values in used.items()},
        peaks=peaks,
        jerk_held=not trajectory.jerk_jumps,
        force_stretch=float(np.sqrt(max((float(part.max()) for part in shares.values()), default=1.0))),
        quantities=quantities,
    )


def _exceeded(trajectory: Trajectory, motion: MotionSamples, backwards: bool) -> NoSolutionError:
    held = _usage(trajectory, motion, QUANTITIES).held()
    name = max(held, key=lambda name: held[name].max())
    quantity, allowed = quantity_named(name), limits(trajectory.path.machine)[name]
    used = fractions(motion.values[name], allowed)
    row, subject = np.unravel_index(np.argmax(used), used.shape)
    fraction, value = float(used[row, subject]), float(motion.values[name][row, subject])
    limit = abs(value) / fraction
    s, t = float(motion.s[row]), float(motion.t_s[row])
    s = 1.0 - s if backwards else s
    return NoSolutionError(
        "retime",
        f"{quantity.subjects[subject]} would reach {abs(value):.4g} {quantity.unit}, {fraction:.1%} of its "
        f"{quantity.words} limit of {limit:g} {quantity.unit}, between two points of the plan, at s = {s:.4f}, "
        f"t = {t:.3f} s",
        "Ask for a smoother path: fewer refine.coefficients, or more refine.corridor_cells.",
        {"actuator": quantity.subjects[subject], "limit": name, "fraction": fraction, "s": s, "t_s": t},
    )
