"""Gains that are stable all along a motion, there and back, with a stated damping."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from pipeline.arguments import require_number
from pipeline.machine.geometry import Machine
from pipeline.progress import QUIET, Monitor
from pipeline.simulate.drives import Drives
from pipeline.simulate.motion import Motion
from pipeline.simulate.plant import require_masses
from pipeline.simulate.tuning.poles import Linearised, Poles, SampledMachine, linearised, loop_poles, sampled_machine

_TRIED, _SEARCHED, _CHECKED = 8, 60, 400
"""Instants of the motion at which gains are tried first, at which they are searched, and checked when found."""
_POSITION_GAINS_PER_S = (1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 6.0, 8.0, 10.0, 12.0, 15.0, 20.0, 25.0, 30.0, 40.0, 60.0, 80.0)
_INTEGRAL_RATIOS = (2.0, 3.0, 4.0, 6.0, 10.0)
"""Integral times in units of 1 / kp."""
_VELOCITY_GAINS = 12
_SLOWEST_PER_S = 3.0
"""Least velocity gain, in units of the largest mass that a drive moves: slower, gravity wins."""
_MARGINS = (0.0, 0.01, 0.03, 0.06)
"""What is asked for beyond the damping at the instants searched, as long as it is missed at those checked."""
_ROUNDS = 6
_CARTS, _TELESCOPES = [0, 1, 2], [3, 4]


class Gains(NamedTuple):
    """Gains of all carts and all telescopes."""

    position_gain_per_s: float
    carts_nspm: float
    telescopes_nspm: float
    integral_time_s: float

    def keys(self, kind: str) -> dict[str, float]:
        """Give the gains of `carts` or `telescopes` by their keys in the configuration."""
        return {
            "position_gain_per_s": self.position_gain_per_s,
            "velocity_gain_nspm": self.carts_nspm if kind == "carts" else self.telescopes_nspm,
            "integral_time_s": self.integral_time_s,
        }


@dataclass(frozen=True, eq=False)
class Tuning:
    """Gains that were found, or that come nearest.

    Attributes
    ----------
    gains : Gains
        With the largest position gain that has the damping; if none has it, with the largest damping.
    drives : Drives
        The drives with these gains.
    before, after : Poles
        Poles with the drives as they were and with these, at instants there (the first half) and back.
    wanted : float
        The damping that was asked for.
    """

    gains: Gains
    drives: Drives
    before: Poles
    after: Poles
    wanted: float

    @property
    def found(self) -> bool:
        """True when the damping is kept at all instants."""
        return bool(self.after.damping.min() >= self.wanted)


def tune_drives(machine: Machine, drives: Drives, motion: Motion, damping: float, monitor: Monitor = QUIET) -> Tuning:
    """Search gains for which all frozen-time poles have a damping ratio, at all instants of a motion, there and back.

    Of these the largest position gain, and then the stiffest; the same for all drives, with one velocity gain for carts
    and one for telescopes. Velocity gains are searched from 3/s times the largest mass that a drive moves to twice the
    least mass per period, where sampling makes a single drive unstable; one group of gains at a time, until nothing
    gets better.
    Poles of frozen instants do not prove the stability of the motion: simulate it.

    Raises
    ------
    ArgumentError
        For a damping ratio that is not between 0 and 1.
    UsageError
        For a machine without masses.
    """
    require_masses(machine)
    damping = require_number("damping", damping, above=0.0, largest=1.0)
    coarse, searched, checked = _near(machine, motion, (_TRIED, _SEARCHED, _CHECKED))
    fine = sampled_machine(checked, drives, motion.period_s)
    search = _Search(
        sampled_machine(coarse, drives, motion.period_s),
        sampled_machine(searched, drives, motion.period_s),
        drives,
        _velocity_gains(checked, drives, motion),
    )
    best = search.start()
    for margin in _MARGINS:
        monitor.progress(f"tuning: damping {damping + margin:g}")
        best = search.best(best, damping + margin)
        after = loop_poles(fine, with_gains(drives, best))
        if after.damping.min() >= damping or not search.has(best, damping + margin):
            break
    return Tuning(best, with_gains(drives, best), loop_poles(fine, drives), after, damping)


def with_gains(drives: Drives, gains: Gains) -> Drives:
    """Give drives with other gains."""
    kv = np.array([gains.carts_nspm] * 3 + [gains.telescopes_nspm] * 2)
    kp = np.full(5, gains.position_gain_per_s)
    return replace(drives, position_gain_per_s=kp, velocity_gain_nspm=kv, integral_gain_npm=kv / gains.integral_time_s)


def _near(machine: Machine, motion: Motion, counts: tuple[int, ...]) -> tuple[Linearised, ...]:
    """Linearise the machine at numbers of evenly spaced rows of a motion, there and back."""
    rows = [np.unique(np.linspace(0, len(motion) - 1, count).round().astype(int)) for count in counts]
    every = np.unique(np.concatenate(rows))
    linear = linearised(machine, motion, every)
    return tuple(linear.take(np.searchsorted(every, part)).both_ways() for part in rows)


def _velocity_gains(linear: Linearised, drives: Drives, motion: Motion) -> tuple[tuple[float, ...], ...]:
    """Velocity gains to try, of carts and of telescopes, with two digits."""
    mass = linear.mass + np.diag(drives.moving_mass_kg)
    most = np.diagonal(mass, axis1=1, axis2=2).max(axis=0)
    least = 1.0 / np.diagonal(np.linalg.inv(mass), axis1=1, axis2=2).max(axis=0)
    return tuple(
        tuple(
            _two_digits(gain)
            for gain in np.geomspace(
                _SLOWEST_PER_S * most[kind].max(), 2.0 * least[kind].min() / motion.period_s, _VELOCITY_GAINS
            )
        )
        for kind in (_CARTS, _TELESCOPES)
    )


def _two_digits(value: float) -> float:
    return float(f"{value:.1e}")


@dataclass(frozen=True, eq=False)
class _Search:
    """Gains are judged at the instants of `coarse` first: most fail there, and cost little."""

    coarse: SampledMachine
    sampled: SampledMachine
    drives: Drives
    velocity_gains: tuple[tuple[float, ...], ...]

    def start(self) -> Gains:
        """Give gains in the middle of what is tried."""
        carts, telescopes = (gains[len(gains) // 2] for gains in self.velocity_gains)
        kp = _POSITION_GAINS_PER_S[len(_POSITION_GAINS_PER_S) // 2]
        return Gains(kp, carts, telescopes, _two_digits(_INTEGRAL_RATIOS[2] / kp))

    def best(self, best: Gains, damping: float) -> Gains:
        """Improve gains, a group of them at a time."""
        score = self._score(best, damping)
        for _ in range(_ROUNDS):
            before = score
            for candidates in (self._of_telescopes, self._of_carts, self._of_integrals):
                for gains in candidates(best):
                    if self._may_beat(score, gains, damping) and (found := self._score(gains, damping)) > score:
                        best, score = gains, found
            if score <= before:
                break
        return best

    def has(self, gains: Gains, damping: float) -> bool:
        """Check whether gains have the damping at the instants searched."""
        return self._score(gains, damping)[0] > 0.0

    def _score(self, gains: Gains, damping: float) -> tuple[float, float]:
        """Order gains: those with the damping by position gain, then by stiffness; all others by their damping."""
        least = self._least(self.sampled, gains)
        return _worth(gains) if least >= damping else (0.0, least)

    def _may_beat(self, score: tuple[float, float], gains: Gains, damping: float) -> bool:
        """Exclude gains that cannot be better, whatever their damping is, or by their damping at few instants."""
        if _worth(gains) <= score:
            return False
        least = self._least(self.coarse, gains)
        return least >= damping or (0.0, least) > score

    def _least(self, sampled: SampledMachine, gains: Gains) -> float:
        return float(loop_poles(sampled, with_gains(self.drives, gains)).damping.min())

    def _of_telescopes(self, gains: Gains) -> Iterator[Gains]:
        ratio = gains.position_gain_per_s * gains.integral_time_s
        for kp in reversed(_POSITION_GAINS_PER_S):
            for velocity in self.velocity_gains[1]:
                time_s = _two_digits(ratio / kp)
                yield gains._replace(position_gain_per_s=kp, telescopes_nspm=velocity, integral_time_s=time_s)

    def _of_carts(self, gains: Gains) -> Iterator[Gains]:
        for velocity in self.velocity_gains[0]:
            yield gains._replace(carts_nspm=velocity)

    def _of_integrals(self, gains: Gains) -> Iterator[Gains]:
        for ratio in _INTEGRAL_RATIOS:
            yield gains._replace(integral_time_s=_two_digits(ratio / gains.position_gain_per_s))


def _worth(gains: Gains) -> tuple[float, float]:
    return gains.position_gain_per_s, gains.carts_nspm * gains.telescopes_nspm / gains.integral_time_s
