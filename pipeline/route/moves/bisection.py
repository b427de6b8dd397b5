"""Straight lines in actuator space, followed by bisection: as few poses as it takes to know what happens between.

Both ends of a line are known. The pose at the midpoint is predicted from the poses and their rates of change at
both ends and corrected by Newton's method, then so is the midpoint of either half, and so on, until the samples show

- that all of them are on one branch: the change of the pose from one to the next agrees with the rates at both
  (trapezoidal rule) up to a fraction of 1/kappa, within which there is no second solution of the closure equations;
- that limits are kept between them: the least margin between two samples is taken to be the lesser of both, less
  half the second difference there. This is exact for a kink, such as the distance of two links has that pass
  through each other, and four times as much as a parabola dips.

Nothing here is singular where an arm is at its serial singularity: the closure is regular there.
"""

from collections.abc import Callable
from dataclasses import dataclass, fields

import numpy as np

from pipeline.arrays import BoolArray, FloatArray, IntArray
from pipeline.machine.geometry import Machine
from pipeline.machine.kinematics import closure_jacobian, closure_residual, newton, solve_rates
from pipeline.machine.samples import PoseSamples

Margins = Callable[[PoseSamples], FloatArray]
"""Computes margins (n, m) of n poses, negative beyond a limit."""

MISS_M = 1e-9
"""How much a link may miss its length at a pose that counts as closing all links."""
ROUNDING = 1e-12
"""How far below zero a margin still counts as rounding: lines may run along a limit."""
_BRANCH = 0.1
"""Deviation from the trapezoidal rule, in metres and radians times kappa, that is too small for another branch."""


@dataclass(frozen=True, eq=False)
class LineSamples:
    """What lines are followed by, at poses of any shape (...).

    Attributes
    ----------
    pose : (..., 6)
        The poses.
    rates : (..., 6, 5)
        Their derivative by the actuator positions; zero where the closure is singular.
    signed_inverse_kappa : (...)
        sign(det H) / kappa: zero at a Type-II singularity.
    margin : (..., m)
        Margins of the limits.
    """

    pose: FloatArray
    rates: FloatArray
    signed_inverse_kappa: FloatArray
    margin: FloatArray

    def at(self, index: "IntArray | BoolArray | tuple[BoolArray, slice]") -> "LineSamples":
        """Return some of the samples."""
        return self.map(lambda column: column[index])

    def map(self, change: Callable[[FloatArray], FloatArray]) -> "LineSamples":
        """Apply a change to every array."""
        return LineSamples(*(change(getattr(self, field.name)) for field in fields(self)))


def combine(a: LineSamples, b: LineSamples, how: Callable[[FloatArray, FloatArray], FloatArray]) -> LineSamples:
    """Combine two sets of samples array by array."""
    return LineSamples(*(how(getattr(a, field.name), getattr(b, field.name)) for field in fields(LineSamples)))


@dataclass(frozen=True, eq=False)
class BisectionResult:
    """What following lines (n,) showed.

    Attributes
    ----------
    doubtful : (n,)
        The ends may be on different branches: nothing else is known of these lines.
    broken : (n, m)
        Limits broken at a sample; a line that breaks one is not searched further for others.
    kappa_max : (n,)
        Largest kappa of the samples.
    """

    doubtful: BoolArray
    broken: BoolArray
    kappa_max: FloatArray


def sample_lines(samples: PoseSamples, margins: Margins) -> LineSamples:
    """Evaluate n poses for following lines."""
    inverse_kappa = samples.signed_inverse_kappa
    return LineSamples(samples.pose, _rates(samples), inverse_kappa, margins(samples))


def _rates(samples: PoseSamples) -> FloatArray:
    """Differentiate the pose by the actuators; zero where the closure is singular. Shape (n, 6, 5)."""
    by_pose = closure_jacobian(samples.machine, samples.pose, samples.q_m)
    regular = np.abs(np.linalg.det(by_pose)) > 1e-14
    rates = np.zeros((len(samples), 6, 5))
    rates[regular] = solve_rates(samples.machine, by_pose[regular])
    return rates


def bisect(
    machine: Machine, margins: Margins, applies: BoolArray, q_m: FloatArray, ends: LineSamples, max_samples: int
) -> BisectionResult:
    """Follow lines between actuator positions (n, 2, 5) whose ends (n, 2) are known.

    `applies` (n, m) tells which margins count on which line.
    Where samples 1/max_samples apart still leave it open whether a limit is kept between them, it counts as kept;
    where they leave it open whether they are on one branch, the line is doubtful.
    """
    open_ends = np.abs(closure_residual(machine, ends.pose, q_m)).max(axis=(1, 2)) > MISS_M
    doubtful: BoolArray = open_ends | (
        np.sign(ends.signed_inverse_kappa[:, 0]) != np.sign(ends.signed_inverse_kappa[:, 1])
    )
    broken = np.asarray((ends.margin < -ROUNDING).any(axis=1)) & applies
    weakest = np.abs(ends.signed_inverse_kappa).min(axis=1)
    lines = np.flatnonzero(~doubtful)
    stretch = _Stretch(lines, np.tile([0.0, 1.0], (len(lines), 1)), ends.at(lines))
    stretch, lost = stretch.refined(machine, margins, q_m)
    doubtful[stretch.line[lost]] = True
    while len(stretch.line):
        stretch, lost = stretch.refined(machine, margins, q_m)
        line = stretch.line
        doubtful[line[lost]] = True
        np.logical_or.at(broken, line, (stretch.samples.margin < -ROUNDING).any(axis=1) & applies[line])
        np.minimum.at(weakest, line, np.abs(stretch.samples.signed_inverse_kappa).min(axis=1))
        lost_branch = stretch.may_switch_branch(q_m)
        if (stretch.at[0, 1] - stretch.at[0, 0]) * max_samples <= 1.0:
            doubtful[line[lost_branch]] = True
            break
        open_ = lost_branch | (stretch.may_break(applies) & ~broken[line].any(axis=1))
        stretch = stretch.halves(open_ & ~doubtful[line])
    with np.errstate(divide="ignore"):
        return BisectionResult(doubtful, broken, 1.0 / weakest)


@dataclass(frozen=True, eq=False)
class _Stretch:
    """Parts of lines with equally spaced samples on them.

    Attributes
    ----------
    line : (k,)
        Which line the part belongs to.
    at : (k, p)
        Where on the line the samples are, 0 to 1.
    samples : (k, p)
        The samples there.
    """

    line: IntArray
    at: FloatArray
    samples: LineSamples

    def rates(self, q_m: FloatArray) -> FloatArray:
        """Change of the pose per line, shape (k, p, 6)."""
        motion = (q_m[self.line, 1] - q_m[self.line, 0])[:, None, :, None]
        rate: FloatArray = (self.samples.rates @ motion)[..., 0]
        return rate

    def refined(self, machine: Machine, margins: Margins, q_m: FloatArray) -> tuple["_Stretch", BoolArray]:
        """Add a sample between any two; the parts (k,) where none was found, or one beyond a singularity, are lost."""
        at, pose, rate = self.at, self.samples.pose, self.rates(q_m)
        between = (at[:, :-1] + at[:, 1:]) / 2.0
        step = (at[:, 1:] - at[:, :-1])[..., None]
        # The cubic through both poses with both rates, half way.
        guess = (pose[:, :-1] + pose[:, 1:]) / 2.0 + step / 8.0 * (rate[:, :-1] - rate[:, 1:])
        ends = q_m[self.line, :, None]
        q = (ends[:, 0] * (1.0 - between[..., None]) + ends[:, 1] * between[..., None]).reshape(-1, 5)
        found, miss = newton(machine, q, guess.reshape(-1, 6))
        shape = between.shape
        new = sample_lines(PoseSamples(machine, found, q), margins)
        new = new.map(lambda column: column.reshape(*shape, *column.shape[1:]))
        lost = (miss.reshape(shape) > MISS_M).any(axis=1)
        lost |= (np.sign(new.signed_inverse_kappa) != np.sign(self.samples.signed_inverse_kappa[:, :1])).any(axis=1)
        merged = combine(self.samples, new, _merge)
        return _Stretch(self.line, _merge(at, between), merged), lost

    def may_switch_branch(self, q_m: FloatArray) -> BoolArray:
        """Tell on which parts (k,) neighbouring samples may be on different branches."""
        pose, rate, nearness = self.samples.pose, self.rates(q_m), np.abs(self.samples.signed_inverse_kappa)
        step = (self.at[:, 1:] - self.at[:, :-1])[..., None]
        gap = np.abs(pose[:, 1:] - pose[:, :-1] - step / 2.0 * (rate[:, 1:] + rate[:, :-1])).max(axis=2)
        far: BoolArray = gap > _BRANCH * np.minimum(nearness[:, 1:], nearness[:, :-1])
        return np.asarray(far.any(axis=1))

    def may_break(self, applies: BoolArray) -> BoolArray:
        """Tell on which parts (k,) of five samples a limit that applies may be broken between two of them."""
        margin = self.samples.margin
        bend = np.abs(margin[:, :-2] - 2.0 * margin[:, 1:-1] + margin[:, 2:])
        near = np.concatenate([bend[:, :1], np.maximum(bend[:, 1:], bend[:, :-1]), bend[:, -1:]], axis=1)
        least = np.minimum(margin[:, 1:], margin[:, :-1]) - near / 2.0
        return np.asarray(((least < -ROUNDING).any(axis=1) & applies[self.line]).any(axis=1))

    def halves(self, rows: BoolArray) -> "_Stretch":
        """Cut parts of five samples in two of three."""
        pieces = [
            (self.line[rows], self.at[rows, part], self.samples.at((rows, part))) for part in (slice(3), slice(2, 5))
        ]
        return _Stretch(
            np.concatenate([piece[0] for piece in pieces]),
            np.concatenate([piece[1] for piece in pieces]),
            combine(pieces[0][2], pieces[1][2], lambda a, b: np.concatenate([a, b])),
        )


def _merge(outer: FloatArray, inner: FloatArray) -> FloatArray:
    """Samples (k, p) and what is between them (k, p - 1), in order. Shape (k, 2 p - 1)."""
    k, p = outer.shape[:2]
    merged = np.empty((k, 2 * p - 1, *outer.shape[2:]))
    merged[:, ::2], merged[:, 1::2] = outer, inner
    return merged
