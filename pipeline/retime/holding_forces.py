"""Whether forces suffice to hold the machine and to set it in motion at all, at its ends and along a path."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from pipeline.arrays import FloatArray
from pipeline.errors import NoSolutionError
from pipeline.machine.dynamics import inverse_dynamics
from pipeline.machine.geometry import Machine
from pipeline.retime.path_dynamics import TermsTable
from pipeline.retime.quantities import kind_named, limits

_CHECK_POINTS = 20_001
"""Values of s at which forces are looked at."""
_LIGHTEN = "Raise machine.limits, lighten machine.dynamics (load_kg, platform)"


@dataclass(frozen=True)
class Shortage:
    """A force that is too large: whose it is, which of the places, how many newtons, and the limit."""

    name: str
    subject: int
    row: int
    force_n: float
    limit_n: float

    def words(self, purpose: str, place: str) -> str:
        """Tell it: what the force is needed for, and where."""
        kind = kind_named(self.name)
        return (
            f"{kind.subjects[self.subject]} needs {abs(self.force_n):.4g} N {purpose} {place}, "
            f"{abs(self.force_n) / self.limit_n:.1%} of its {kind.words} limit of {self.limit_n:g} N"
        )


def resting_forces(machine: Machine, pose: FloatArray, carts_m: FloatArray) -> dict[str, FloatArray]:
    """Forces that hold the machine against gravity at poses (n, 6) and cart positions (n, 3); none without masses.

    Returns
    -------
    mapping
        "force" of the drives (n, 5) and "link_force" (n, 6), in newtons.
    """
    if machine.masses is None:
        return {}
    still, carts_still = np.zeros_like(pose), np.zeros_like(carts_m)
    found = inverse_dynamics(machine, machine.masses, pose, carts_m, still, still, carts_still)
    return {"force": found.drive_n, "link_force": found.link_n}


def shortage(machine: Machine, forces: Mapping[str, FloatArray]) -> Shortage | None:
    """Find the force (n, subjects) that uses up most of its limit; None where all are below theirs."""
    allowed = limits(machine)
    worst, most = None, 1.0
    for name, needed in forces.items():
        fractions = np.abs(needed) / allowed[name]
        row, subject = np.unravel_index(np.argmax(fractions), fractions.shape)
        if fractions[row, subject] >= most:
            most = fractions[row, subject]
            worst = Shortage(name, int(subject), int(row), float(needed[row, subject]), float(allowed[name][subject]))
    return worst


def require_ends_held(machine: Machine, pose: FloatArray, carts_m: FloatArray) -> None:
    """Refuse a task whose start or goal gravity alone makes impossible, whatever the way between them.

    Dry friction helps to hold: drives have to make up for what it leaves.

    Parameters
    ----------
    pose : (2, 6)
        At the start and at the goal.
    carts_m : (2, 3)
        Positions of the carts there.

    Raises
    ------
    NoSolutionError
        With the limit and the pose; no path can help there.
    """
    forces = resting_forces(machine, pose, carts_m)
    if machine.masses is None:
        return
    drives = forces["force"]
    forces["force"] = np.sign(drives) * np.maximum(np.abs(drives) - machine.masses.friction_n, 0.0)
    for row, end in enumerate(("start", "goal")):
        found = shortage(machine, {name: part[row : row + 1] for name, part in forces.items()})
        if found is not None:
            raise NoSolutionError(
                "retime",
                f"{found.words('just to hold the machine', f'at the {end}')}, at {pose_words(pose[row])}",
                f"{_LIGHTEN}, or give the task another {end}.",
                _facts(found, float(row)),
            )


def require_standing(table: TermsTable, backwards: bool = False) -> None:
    """Refuse a path somewhere on which gravity and dry friction alone take more force than there is.

    Parameters
    ----------
    backwards : bool
        The path is that of the way back: s is told along the way there.

    Raises
    ------
    NoSolutionError
        With the limit and the pose at which it is exceeded most.
    """
    path, machine = table.path, table.path.machine
    ends = np.array([1.0, 0.0] if backwards else [0.0, 1.0])
    require_ends_held(machine, path.pose(ends), path.q(ends)[:, :3])
    terms = table.at(np.linspace(0.0, 1.0, _CHECK_POINTS))
    found = shortage(machine, terms.resting())
    if found is None:
        return
    held = found.name != "force" or terms.friction()[found.row, found.subject] == 0.0
    there = float(terms.s[found.row])
    place = 1.0 - there if backwards else there
    purpose = "just to hold the machine" if held else "against gravity and dry friction alone, however slow it moves,"
    advice = "keep farther away from singularities with a smaller refine.kappa_max."
    raise NoSolutionError(
        "retime",
        f"{found.words(purpose, f'at s = {place:.4f}')}, at {pose_words(path.pose(there))}",
        f"{_LIGHTEN}, or {advice}" if held else f"{_LIGHTEN}, lower machine.dynamics.friction, or {advice}",
        _facts(found, place),
    )


def pose_words(pose: FloatArray) -> str:
    """Name a pose (6,)."""
    x, y, z, rx, ry, rz = pose
    angles = ", ".join(f"{name} {np.rad2deg(value):.1f}" for name, value in (("rx", rx), ("ry", ry), ("rz", rz)))
    return f"the pose x {x:.3f}, y {y:.3f}, z {z:.3f} m, {angles} degrees"


def _facts(found: Shortage, s: float) -> dict[str, object]:
    return {
        "actuator": kind_named(found.name).subjects[found.subject],
        "limit": found.name,
        "force_n": found.force_n,
        "limit_n": found.limit_n,
        "s": s,
    }
