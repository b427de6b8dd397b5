"""The proof of a motion: velocity, acceleration and jerk of every actuator are within their limits at every instant.

What is proven is of the time law and the splines as they are stored, extended by their own polynomials where rounding
carries s past an end of the path. Where accelerations jump by design, there is no jerk to be limited.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from pipeline.arrays import FloatArray, arrays_sha256
from pipeline.errors import NoSolutionError
from pipeline.inclusion.closure import working_precision
from pipeline.machine.geometry import ACTUATORS, Machine
from pipeline.retime.drivable import require_locked_at_rest, require_smooth
from pipeline.retime.proof.continuity import Jumps, find_jumps, leaves_path
from pipeline.retime.proof.exact_motion import exact_motion
from pipeline.retime.proof.kinematic_use import KinematicUse, kinematic_use
from pipeline.retime.quantities import JERK, limits, quantity_named
from pipeline.retime.result import Trajectory

NAMES = ("velocity", "acceleration", JERK)
"""What is proven, in the order of derivatives."""
_BITS = 96
"""Precision: polynomials of degree 20 about the middle of a knot span lose some twenty bits."""
_AGAIN = "Time the path again: gantry-tau retime CONFIG --force"


@dataclass(frozen=True, eq=False)
class MotionProof:
    """What is proven of a motion for every instant.

    Attributes
    ----------
    law_sha256 : str
        Hash of the time law and of the splines it runs along.
    use : KinematicUse
        Fractions of the limits of velocity, acceleration and jerk.
    jumps : Jumps
        What position, velocity and acceleration jump by between pieces of the law.
    leaves_path_s : float or None
        A time from which on s is not proven to be on the path; None if it is throughout.
    jerk_limited : bool
        Whether jerk has limits that the law keeps.
    """

    law_sha256: str
    use: KinematicUse
    jumps: Jumps
    leaves_path_s: float | None
    jerk_limited: bool

    @property
    def fractions(self) -> Mapping[str, FloatArray]:
        """Proven fractions (5,) by the names of the quantities."""
        rows = zip(NAMES, self.use.proven, strict=True)
        return {name: row for name, row in rows if name != JERK or self.jerk_limited}

    @property
    def stretch(self) -> float:
        """Least factor (at least one) by which time has to be stretched for all limits to be proven."""
        powers = np.arange(1, len(NAMES) + 1)
        return float(max(1.0, *(self.use.proven.max(axis=1) ** (1.0 / powers))))


@lru_cache(maxsize=4)
def prove_motion(trajectory: Trajectory, *, jerk: bool = True) -> MotionProof:
    """Prove which part of its kinematic limits a motion uses at most; the proofs of the last motions are kept.

    Without `jerk` it need not be limited, and accelerations may jump (`retime.jerk: off`).
    """
    allowed = kinematic_limits(trajectory.path.machine, jerk=jerk)
    with working_precision(_BITS):
        motion = exact_motion(trajectory)
        use = kinematic_use(motion, allowed)
        with np.errstate(invalid="ignore"):
            peaks = np.where(np.isfinite(allowed), use.attained * allowed, 0.0).max(axis=1)[:2]
        jumps, off = find_jumps(motion, peaks), leaves_path(motion)
    return MotionProof(law_sha256(trajectory), use, jumps, off, bool(np.isfinite(allowed[2]).any()))


def require_proven(trajectory: Trajectory, backwards: bool = False, *, jerk: bool = True) -> MotionProof:
    """Prove a motion, and raise where it jumps, moves a locked actuator or may exceed a limit.

    Parameters
    ----------
    backwards : bool
        The trajectory is the way back: s is reported along the way there.
    jerk : bool
        Jerk is to be limited where the machine limits it; otherwise accelerations may jump.

    Raises
    ------
    NoSolutionError
        With what may exceed which limit, by how much, and where.
    """
    require_smooth(trajectory.path)
    require_locked_at_rest(trajectory.path)
    proof = prove_motion(trajectory, jerk=jerk)
    _refuse_jumps(trajectory, proof)
    order, actuator = np.unravel_index(np.argmax(proof.use.proven), proof.use.proven.shape)
    fraction, attained = (float(part[order, actuator]) for part in (proof.use.proven, proof.use.attained))
    if not fraction <= 1.0:
        quantity = quantity_named(NAMES[order])
        t_s, s = float(proof.use.t_s[order, actuator]) + trajectory.dwell_s[0], float(proof.use.s[order, actuator])
        s = 1.0 - s if backwards else s
        raise NoSolutionError(
            "retime",
            f"{ACTUATORS[actuator]} is not proven to keep its {quantity.words} limit at every instant: it uses "
            f"{attained:.2%} of it at s = {s:.4f}, t = {t_s:.4f} s, and nowhere more than {fraction:.2%}",
            "Ask for a smoother path: fewer refine.coefficients, or more refine.corridor_cells.",
            {"actuator": ACTUATORS[actuator], "limit": quantity.name, "fraction": fraction, "s": s, "t_s": t_s},
        )
    return proof


def _refuse_jumps(trajectory: Trajectory, proof: MotionProof) -> None:
    """Refuse a law that passes the ends of the path, or whose position, velocity or limited acceleration jumps."""
    if proof.leaves_path_s is not None:
        t_s = proof.leaves_path_s + trajectory.dwell_s[0]
        raise NoSolutionError(
            "retime", f"the time law leaves the path at t = {t_s:.4f} s", _AGAIN, {"limit": "path", "t_s": t_s}
        )
    names = ("position", "velocity", "acceleration")[: 3 if proof.jerk_limited else 2]
    jumps = proof.jumps
    for name, jump, allowed, t_s in zip(names, jumps.largest, jumps.allowed, jumps.t_s, strict=False):
        if not jump <= allowed:
            t_s += trajectory.dwell_s[0]
            raise NoSolutionError(
                "retime",
                f"the {name} of an actuator jumps by {jump:.3g} (m, s) at t = {t_s:.4f} s; up to {allowed:.3g} is "
                "rounding",
                _AGAIN,
                {"limit": f"jump of {name}", "t_s": float(t_s)},
            )


def kinematic_limits(machine: Machine, *, jerk: bool = True) -> FloatArray:
    """Give the limits of velocity, acceleration and jerk, (3, 5); infinite where there is none."""
    by_name = limits(machine)
    rows = np.stack([by_name[name] for name in NAMES])
    rows[2] = rows[2] if jerk else np.inf
    return rows


def law_sha256(trajectory: Trajectory) -> str:
    """Hash everything that the positions of the actuators follow from at any time, bit by bit."""
    spline, law = trajectory.path.spline, trajectory.time_law
    arrays = {
        "knots": spline.t,
        "coefficients": spline.c,
        "t_s": law.x,
        "law": law.c,
        "dwell_s": np.array(trajectory.dwell_s),
    }
    return arrays_sha256(f"degree {int(spline.k)}", arrays)
