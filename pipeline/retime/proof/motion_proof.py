"""The proof of a motion: every limit is kept at every instant, by actuators, forces, links and the TCP.

What is proven is of the time law and the splines as they are stored, extended by their own polynomials where rounding
carries s past an end of the path. Where accelerations jump by design, there is no jerk to be limited.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
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
from pipeline.retime.proof.load_use import LoadUse
from pipeline.retime.proof.motion_loads import prove_loads, require_loads
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
    loads : LoadUse or None
        Forces and the TCP's motion; None where they are not bounded.
    """

    law_sha256: str
    use: KinematicUse
    jumps: Jumps
    leaves_path_s: float | None
    jerk_limited: bool
    loads: LoadUse | None = None

    @property
    def fractions(self) -> Mapping[str, FloatArray]:
        """Proven fractions (subjects,) by the names of the quantities that have a limit."""
        rows = zip(NAMES, self.use.proven, strict=True)
        found = {name: row for name, row in rows if name != JERK or self.jerk_limited}
        return found if self.loads is None else found | self.loads.fractions

    @property
    def peaks(self) -> Mapping[str, FloatArray]:
        """Proven bounds (subjects,) of forces and the TCP's motion, in SI units, by the names of the quantities."""
        return {} if self.loads is None else self.loads.peaks

    @property
    def intervals(self) -> int:
        """Count the intervals of time that prove it."""
        return self.use.intervals + (0 if self.loads is None else self.loads.intervals)

    @property
    def stretch(self) -> float:
        """Least factor (at least one) by which time has to be stretched for all limits to be proven."""
        powers = np.arange(1, len(NAMES) + 1)
        kinematic = float(max(1.0, *(self.use.proven.max(axis=1) ** (1.0 / powers))))
        return kinematic if self.loads is None else max(kinematic, self.loads.stretch)


def prove_motion(trajectory: Trajectory, *, jerk: bool = True, loads: bool = False) -> MotionProof:
    """Prove which part of its limits a motion uses at most; the proofs of the last motions are kept.

    Without `jerk` it need not be limited, and accelerations may jump (`retime.jerk: off`). With `loads` forces and the
    motion of the TCP are bounded, too.

    Raises
    ------
    NoSolutionError
        Where loads are limited, and the machine is not proven to be regular.
    """
    proof = _prove_rates(trajectory, jerk=jerk)
    return replace(proof, loads=prove_loads(trajectory)) if loads else proof


@lru_cache(maxsize=4)
def _prove_rates(trajectory: Trajectory, *, jerk: bool) -> MotionProof:
    """Prove what does not need the pose."""
    allowed = kinematic_limits(trajectory.path.machine, jerk=jerk)
    with working_precision(_BITS):
        motion = exact_motion(trajectory)
        use = kinematic_use(motion, allowed)
        with np.errstate(invalid="ignore"):
            peaks = np.where(np.isfinite(allowed), use.attained * allowed, 0.0).max(axis=1)[:2]
        jumps, off = find_jumps(motion, peaks), leaves_path(motion)
    return MotionProof(law_sha256(trajectory), use, jumps, off, bool(np.isfinite(allowed[2]).any()))


def require_proven(
    trajectory: Trajectory, backwards: bool = False, *, jerk: bool = True, loads: bool = False
) -> MotionProof:
    """Prove a motion, and raise where it jumps, moves a locked actuator or may exceed a limit.

    Parameters
    ----------
    backwards : bool
        The trajectory is the way back: s is reported along the way there.
    jerk : bool
        Jerk is to be limited where the machine limits it; otherwise accelerations may jump.
    loads : bool
        Forces and the motion of the TCP have to keep their limits, too.

    Raises
    ------
    NoSolutionError
        With what may exceed which limit, by how much, and where.
    """
    require_smooth(trajectory.path)
    require_locked_at_rest(trajectory.path)
    proof = prove_motion(trajectory, jerk=jerk, loads=loads)
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
    if proof.loads is not None:
        require_loads(trajectory, proof.loads, backwards)
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
