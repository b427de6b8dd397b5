"""The loads of a motion: forces in drives and links, and the TCP's speed and acceleration, proven at every instant.

The loads along a curve do not depend on the time law, nor on which way it is driven: they are bounded once for the way
there and back. Knots 1 - s are rounded, which changes positions by some 1e-16 m and loads by some 1e-13 of them: bounds
of the other way are enlarged by 1e-9. The check of a certificate evaluates the path of the way back itself.
"""

from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from pipeline.arrays import FloatArray
from pipeline.errors import NoSolutionError
from pipeline.inclusion.closure import working_precision
from pipeline.refine.result import Path
from pipeline.retime.path_dynamics import needs_kinematics
from pipeline.retime.proof.exact_motion import exact_law
from pipeline.retime.proof.load_use import COLUMNS, LoadUse, load_use
from pipeline.retime.proof.path_loads import BoxLoads, path_loads
from pipeline.retime.quantities import limited, quantity_named
from pipeline.retime.result import Trajectory

_BITS = 64
_ROUNDING, _WIDER = 2.0**-53, 1.0 + 1e-9
"""How far 1 - s may be rounded, and how much wider bounds of the other way are for it."""
_ADVICE = {
    "force": "Raise the force_n of machine.limits, or lighten machine.dynamics.",
    "link_force": "Raise machine.limits.link_force_n, or lighten machine.dynamics.",
}


@dataclass(frozen=True, eq=False)
class _Curve:
    """A path as a curve: the same if it is driven backwards, with knots 1 - s to within their rounding."""

    path: Path

    def __hash__(self) -> int:
        coefficients = self.path.spline.c
        return hash(frozenset((coefficients.tobytes(), coefficients[::-1].tobytes())))

    def __eq__(self, other: object) -> bool:
        return isinstance(other, _Curve) and (self.is_same(other.path) or self.is_reverse(other.path))

    def is_same(self, path: Path) -> bool:
        """Check whether a path is the same function of s, with the same known poses."""
        ours, theirs = self.path.spline, path.spline
        same = ours.k == theirs.k and np.array_equal(ours.t, theirs.t) and np.array_equal(ours.c, theirs.c)
        return same and self._has_poses(path.node_pose) and self.path.machine is path.machine

    def is_reverse(self, path: Path) -> bool:
        """Check whether a path is q(1 - s), but for the rounding of 1 - s."""
        ours, theirs = self.path.spline, path.spline
        same = ours.k == theirs.k and np.array_equal(ours.c, theirs.c[::-1]) and len(ours.t) == len(theirs.t)
        same = same and bool(np.abs(1.0 - theirs.t - ours.t[::-1]).max() <= _ROUNDING)
        return same and self._has_poses(path.node_pose[::-1]) and self.path.machine is path.machine

    def _has_poses(self, pose: FloatArray) -> bool:
        """Check whether known poses (k, 6) are these: actuators alone do not tell the assembly."""
        return np.array_equal(self.path.node_pose, pose)


@lru_cache(maxsize=2)
def _loads(curve: _Curve) -> tuple[_Curve, list[BoxLoads]]:
    """Bound the loads along a curve, and say along which of its two directions."""
    return curve, path_loads(curve.path)


@lru_cache(maxsize=4)
def prove_loads(trajectory: Trajectory) -> LoadUse | None:
    """Bound the forces and the TCP's motion at every instant; None where neither masses nor limits ask for them.

    Without a limit, what cannot be bounded is not.

    Raises
    ------
    NoSolutionError
        Where the machine is not proven to be regular along the path, so that what is limited cannot be bounded.
    """
    path = trajectory.path
    if not needs_kinematics(path.machine):
        return None
    with working_precision(_BITS):
        try:
            curve, loads = _loads(_Curve(path))
        except NoSolutionError:
            if set(COLUMNS) & set(limited(path.machine)):
                raise
            return None
        law, backwards = exact_law(trajectory), not curve.is_same(path)
        if backwards:
            law = tuple(replace(piece, polynomial=1 - piece.polynomial) for piece in law)
        use = load_use(law, loads, path.machine, wider=_WIDER if backwards else 1.0)
    return replace(use, s=1.0 - use.s) if backwards else use


def require_loads(trajectory: Trajectory, use: LoadUse, backwards: bool) -> None:
    """Raise where a force or the TCP may exceed its limit; s is that along the way there for the way back, too.

    Raises
    ------
    NoSolutionError
        With what may exceed which limit, by how much, and where.
    """
    over = np.where(use.limited & use.known, use.proven, 0.0)
    column = int(over.argmax())
    if over[column] <= 1.0:
        return
    name, part = next((name, part) for name, part in COLUMNS.items() if part.start <= column < part.stop)
    quantity, fraction = quantity_named(name), float(over[column])
    subject = quantity.subjects[column - part.start]
    t_s, s = float(use.t_s[column]) + trajectory.dwell_s[0], float(use.s[column])
    s = 1.0 - s if backwards else s
    raise NoSolutionError(
        "retime",
        f"{subject} is not proven to keep its {quantity.words} limit at every instant: it may use {fraction:.2%} of it "
        f"near s = {s:.4f}, t = {t_s:.4f} s",
        _ADVICE.get(name, f"Raise machine.limits.{quantity.key}, or lower retime.speed."),
        {"actuator": subject, "limit": name, "fraction": fraction, "s": s, "t_s": t_s},
    )
