"""Check that forces suffice to hold the machine along a path, and to set it in motion at all."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from pipeline.arrays import FloatArray
from pipeline.errors import NoSolutionError
from pipeline.machine.geometry import Machine
from pipeline.retime.path_dynamics import PathDynamicsTable
from pipeline.retime.quantities import at_rest, both_sides, fractions, limits, quantity_named

_CHECK_POINTS = 20_001
"""Values of s at which forces are evaluated."""
_LIGHTEN = "Raise machine.limits, lighten machine.dynamics (load_kg, platform)"


@dataclass(frozen=True)
class ForceShortfall:
    """A force above its limit.

    Attributes
    ----------
    name : str
        Name of the quantity: "force" of a drive or "link_force".
    subject, row : int
        Number of the drive or link, and of the place.
    force_n, limit_n : float
        The force needed and its limit on that side, in newtons.
    """

    name: str
    subject: int
    row: int
    force_n: float
    limit_n: float

    def words(self, purpose: str, place: str) -> str:
        """Describe it in words: what the force is needed for, and where."""
        quantity = quantity_named(self.name)
        return (
            f"{quantity.subjects[self.subject]} needs {abs(self.force_n):.4g} N {purpose} {place}, "
            f"{abs(self.force_n) / self.limit_n:.1%} of its {quantity.words} limit of {self.limit_n:g} N"
        )


def find_shortfall(machine: Machine, forces: Mapping[str, FloatArray]) -> ForceShortfall | None:
    """Find the force (n, subjects) that exceeds its limit most; None where all are below their limits."""
    allowed = limits(machine)
    worst, most = None, 1.0
    for name, needed in forces.items():
        used = fractions(needed, allowed[name])
        row, subject = np.unravel_index(np.argmax(used), used.shape)
        if used[row, subject] >= most:
            most, force = used[row, subject], float(needed[row, subject])
            limit = both_sides(allowed[name])[0 if force > 0.0 else 1, subject]
            worst = ForceShortfall(name, int(subject), int(row), force, float(limit))
    return worst


def require_standing(table: PathDynamicsTable, backwards: bool = False) -> None:
    """Refuse a path on which gravity and dry friction alone exceed a force limit anywhere.

    Parameters
    ----------
    backwards : bool
        The path is the way back: s is reported along the way there.

    Raises
    ------
    NoSolutionError
        With the limit, and the pose where it is exceeded most.
    """
    path, machine = table.path, table.path.machine
    dynamics = table.at(np.linspace(0.0, 1.0, _CHECK_POINTS))
    found = find_shortfall(machine, at_rest(dynamics))
    if found is None:
        return
    held = found.name != "force" or dynamics.friction()[found.row, found.subject] == 0.0
    there = float(dynamics.s[found.row])
    place = 1.0 - there if backwards else there
    purpose = "just to hold the machine" if held else "against gravity and dry friction alone, however slowly it moves,"
    end = {0.0: "start", 1.0: "goal"}.get(round(place, 3))
    advice = (
        "keep farther away from singularities with a smaller refine.kappa_max."
        if end is None
        else f"give the task another {end}."
    )
    raise NoSolutionError(
        "retime",
        f"{found.words(purpose, f'at s = {place:.4f}')}, at {pose_words(path.pose(there))}",
        f"{_LIGHTEN}, or {advice}" if held else f"{_LIGHTEN}, lower machine.dynamics.friction, or {advice}",
        _facts(found, place),
    )


def pose_words(pose: FloatArray) -> str:
    """Describe a pose (6,) in words."""
    x, y, z, rx, ry, rz = pose
    angles = ", ".join(
        f"{name} {round(float(np.rad2deg(value)), 1) + 0.0:.1f}" for name, value in (("rx", rx), ("ry", ry), ("rz", rz))
    )
    return f"the pose x {x:.3f}, y {y:.3f}, z {z:.3f} m, {angles} degrees"


def _facts(found: ForceShortfall, s: float) -> dict[str, object]:
    return {
        "actuator": quantity_named(found.name).subjects[found.subject],
        "limit": found.name,
        "force_n": found.force_n,
        "limit_n": found.limit_n,
        "s": s,
    }
