"""How much of the actuators' limits a trajectory uses, measured more densely than it was planned."""

from dataclasses import dataclass

import numpy as np

from pipeline.errors import NoSolutionError
from pipeline.machine.geometry import ACTUATORS, FloatArray
from pipeline.retime.result import Trajectory, TrajectorySamples

ALLOWED_USAGE = 1.001
"""Largest fraction of a limit that still counts as holding it: what a grid leaves open between its points."""
_PARTS = 10
"""Parts each piece of the time law is divided into."""


@dataclass(frozen=True, eq=False)
class Usage:
    """Largest fraction of the velocity and acceleration limit that each actuator uses. Shapes (5,)."""

    velocity: FloatArray
    acceleration: FloatArray

    @property
    def largest(self) -> float:
        """The largest fraction of all."""
        return float(max(self.velocity.max(), self.acceleration.max()))

    @property
    def stretch(self) -> float:
        """Least factor (one or more) by which time has to be stretched for no fraction to be above one."""
        return float(max(1.0, self.velocity.max(), np.sqrt(self.acceleration.max())))


@dataclass(frozen=True, eq=False)
class TrajectoryFigures:
    """A sampled trajectory in numbers."""

    duration_s: float
    period_s: float
    samples: int
    usage: Usage


def measure_trajectory(trajectory: Trajectory, samples: TrajectorySamples) -> TrajectoryFigures:
    """Reduce a trajectory and its samples to figures; limits are looked at between the samples, too."""
    return TrajectoryFigures(samples.duration_s, samples.period_s, len(samples), measure_usage(trajectory))


def measure_usage(trajectory: Trajectory) -> Usage:
    """Measure the largest fractions of |qd| and |qdd| at eleven points of every piece, its two ends included."""
    _, velocity, acceleration = _fractions(trajectory)
    return Usage(velocity.max(axis=(0, 1)), acceleration.max(axis=(0, 1)))


def require_limits(trajectory: Trajectory) -> Usage:
    """Measure the usage and insist on it.

    Raises
    ------
    NoSolutionError
        When an actuator exceeds a limit by more than 0.1 %; names the actuator, the limit, the value and the place.
    """
    usage = measure_usage(trajectory)
    if usage.largest > ALLOWED_USAGE:
        raise _exceeded(trajectory)
    return usage


def _exceeded(trajectory: Trajectory) -> NoSolutionError:
    t_s, velocity, acceleration = _fractions(trajectory)
    machine = trajectory.path.machine
    fractions, name, unit, limits = (
        (velocity, "velocity", "m/s", machine.velocity_mps)
        if velocity.max() > acceleration.max()
        else (acceleration, "acceleration", "m/s^2", machine.acceleration_mps2)
    )
    piece, part, actuator = np.unravel_index(np.argmax(fractions), fractions.shape)
    fraction, limit, t = float(fractions[piece, part, actuator]), float(limits[actuator]), float(t_s[piece, part])
    s = float(trajectory.s(t))
    return NoSolutionError(
        "retime",
        f"{ACTUATORS[actuator]} would reach {fraction * limit:.4g} {unit}, {fraction:.1%} of its {name} limit of "
        f"{limit:g} {unit}, between two grid points at s = {s:.4f}, t = {t:.3f} s",
        "Ask for a smoother path: fewer refine.coefficients, or more refine.corridor_cells.",
        {"actuator": ACTUATORS[actuator], "limit": name, "fraction": fraction, "s": s, "t_s": t},
    )


def _fractions(trajectory: Trajectory) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Times (n, 11), and |qd| and |qdd| there over their limits (n, 11, 5), for the n pieces of the time law.

    Accelerations jump where two pieces meet: both have their own value there.
    """
    law, path, machine = trajectory.time_law, trajectory.path, trajectory.path.machine
    elapsed = np.diff(law.x)[:, None] * np.linspace(0.0, 1.0, _PARTS + 1)
    half, sd0, s0 = law.c[..., None]
    s = np.clip(s0 + (sd0 + half * elapsed) * elapsed, 0.0, 1.0)
    sd = (sd0 + 2.0 * half * elapsed)[..., None]
    first, second = path.q(s, 1), path.q(s, 2)
    velocity = np.abs(first * sd) / machine.velocity_mps
    acceleration = np.abs(second * sd**2 + first * 2.0 * half[..., None]) / machine.acceleration_mps2
    return law.x[:-1, None] + elapsed, velocity, acceleration
