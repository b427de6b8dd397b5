"""The check of a time law: the limits of velocity, acceleration and jerk hold at every instant, by other code.

It shares nothing with the proof but the numbers of path and law: neither rational nor ball arithmetic, but intervals of
floats, and Taylor coefficients of the composed motion in place of the composed polynomials.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field

import numpy as np
from scipy.interpolate import PPoly

from pipeline.arrays import FloatArray
from pipeline.certify.recheck.arithmetic.time_law import PASSED_BY, largest_rates
from pipeline.certify.recheck.claims.claim import Claim
from pipeline.machine.geometry import Machine
from pipeline.refine.result import Path

LAW = "the proof is of this time law"
ON_PATH = "s stays on the path"
SMOOTH = "the path has no corners"
LOCKED = "locked actuators do not move"
_NAMES = ("velocity", "acceleration", "jerk")
_LEAST_TRAVEL_M = 1e-9
"""Travel of an actuator that counts as none."""


@dataclass(frozen=True, eq=False)
class StatedMotion:
    """What is stated of a motion: the hash of its law, the parts of the limits it uses, and loads in SI units, by name.

    Of the actuators (5,), of links (6,) or of the TCP (1,).
    """

    law_sha256: str
    fractions: Mapping[str, FloatArray]
    peaks: Mapping[str, FloatArray] = field(default_factory=dict)


def within_limits(name: str) -> str:
    """Say the claim of a quantity."""
    return f"{name} stays within its bound and limit at every instant"


def verify_time_law(
    path: Path, law: PPoly, law_sha256: str, stated: StatedMotion, *, jerk: bool = True
) -> Iterator[Claim]:
    """Verify what is stated of a law along a path, whose own hash is given.

    Without `jerk` it need not be limited, and accelerations may jump: the configuration says so, not the law.
    """
    yield Claim(LAW, stated.law_sha256 == law_sha256, law_sha256[:12])
    limits = _limits(path.machine)
    names = _NAMES if jerk and np.isfinite(limits[2]).any() else _NAMES[:2]
    fractions = np.full((3, 5), np.inf)
    for row, name in enumerate(names):
        fractions[row] = stated.fractions.get(name, np.inf)
    with np.errstate(all="ignore"):
        enough = np.where(np.isfinite(limits), fractions * limits * (1.0 - 1e-12), np.inf)
        found, on_path = largest_rates(path.spline, law, enough)
        used = np.where(np.isfinite(limits), found / limits, 0.0)
    for row, name in enumerate(names):
        holds = bool((found[row] <= enough[row]).all() and (fractions[row] <= 1.0).all())
        text = f"{used[row].max():.6g} of the limit; stated {fractions[row].max():.6g}"
        yield Claim(within_limits(name), holds, text)
    yield Claim(ON_PATH, on_path, f"from 0 to 1, to within {PASSED_BY:g}" if on_path else "it may leave 0 to 1")
    yield _corners(path, 2 if "jerk" in names else 1)
    yield _locked(path)
    ends = law.x[[0, -1]]
    reached = np.abs(law(ends) - [0.0, 1.0]).max() <= PASSED_BY
    jump = _largest_jump(path, law, 3 if "jerk" in names else 2)
    allowed = np.array([1e-8, 1e-5 * found[0].max(), 1e-4 * found[1].max()])[: len(jump)]
    yield Claim(
        "the motion goes from rest to rest without jumps",
        bool(reached and (jump <= allowed).all()),
        ", ".join(f"{value:.2g} {unit}" for value, unit in zip(jump, ("m", "m/s", "m/s2"), strict=False)),
    )


def _corners(path: Path, order: int) -> Claim:
    """Verify that derivatives up to an order are continuous: at a knot of multiplicity m, those up to k - m are."""
    t, degree = path.spline.t, int(path.spline.k)
    knots, counts = np.unique(t[(t > 0.0) & (t < 1.0)], return_counts=True)
    continuous = degree - counts
    if not (rough := np.flatnonzero(continuous < order)).size:
        return Claim(SMOOTH, verified=True, found=f"{order} continuous derivatives")
    first = rough[0]
    words = f"derivative {continuous[first] + 1} jumps at s = {knots[first]:.6g}"
    return Claim(SMOOTH, verified=False, found=words)


def _locked(path: Path) -> Claim:
    """Verify that actuators without velocity stay where they are: splines are within their coefficients."""
    travel = np.ptp(path.spline.c[:, ~(path.machine.velocity_mps > 0.0)], axis=0)
    return Claim(LOCKED, bool((travel < _LEAST_TRAVEL_M).all()), f"{travel.max(initial=0.0):.2g} m of {travel.size}")


def _limits(machine: Machine) -> FloatArray:
    """Give the limits, (3, 5); those of locked actuators, zero, limit nothing: `LOCKED` is a claim of its own."""
    velocity = np.where(machine.velocity_mps > 0.0, machine.velocity_mps, np.inf)
    return np.stack([velocity, machine.acceleration_mps2, machine.jerk_mps3])


def _largest_jump(path: Path, law: PPoly, orders: int) -> FloatArray:
    """Compute the largest jumps of position, velocity and acceleration (orders,), between pieces and to rest."""
    begins, ends = (_states(path, law, part) for part in (0.0, np.diff(law.x)))
    rest = np.zeros((1, *begins.shape[1:]))
    start, goal = rest.copy(), rest.copy()
    start[0, 0], goal[0, 0] = path.q(0.0), path.q(1.0)
    before, after = np.concatenate([start, ends]), np.concatenate([begins, goal])
    return np.asarray(np.abs(before - after).max(axis=(0, 2))[:orders])


def _states(path: Path, law: PPoly, elapsed: FloatArray | float) -> FloatArray:
    """Evaluate position, velocity and acceleration in every piece after some seconds, (pieces, 3, 5)."""
    s, sd, sdd = (np.zeros(law.c.shape[1]) for _ in range(3))
    for row in law.c:
        s, sd, sdd = s * elapsed + row, sd * elapsed + s, sdd * elapsed + 2.0 * sd
    s, sd, sdd = s.clip(0.0, 1.0), sd[:, None], sdd[:, None]
    q1, q2 = path.q(s, 1), path.q(s, 2)
    return np.stack([path.q(s), q1 * sd, q2 * sd**2 + q1 * sdd], axis=1)
