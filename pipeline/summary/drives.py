"""What the drives feel, in the summary."""

from typing import TYPE_CHECKING

import numpy as np

from pipeline.summary.section import DRIVES, SKIPPED, Section

if TYPE_CHECKING:
    from pipeline.arrays import FloatArray
    from pipeline.machine.actuator_space import Directed
    from pipeline.retime.quality.drives import MotionDrives


def drives_part(there: "MotionDrives", names: tuple[str, ...]) -> Section:
    """Give the extreme of each figure, where it is, and the direction it belongs to.

    `summary.whole` makes it a part of its own. Without masses there is amplification alone.
    """
    felt, amplified = there.felt, there.amplified
    section: Section = {"status": "done", **dict.fromkeys(_OF_MASSES, SKIPPED)}
    if felt is not None:
        section["reflected_mass_kg"] = {
            name: {"least": float(masses.min()), "largest": float(masses.max()), **_where(there, int(masses.argmax()))}
            for name, masses in zip(names, felt.reflected_mass_kg.T, strict=True)
        }
        section["reflected_mass_worst_kg"] = _extreme(there, felt.worst_mass_kg, largest=True)
        section["stiffness_least_npm"] = _extreme(there, felt.stiffness_npm, largest=False)
        section["damping_least_nspm"] = _extreme(there, felt.damping_nspm, largest=False)
    section["amplification_max"] = {
        unit: {**_extreme(there, figure, largest=True), "by_drive": by_drive.max(axis=0).tolist()}
        for unit, figure, by_drive in (
            ("mm_per_mm", amplified.position, amplified.position_by_drive),
            ("mrad_per_mm", amplified.angle, amplified.angle_by_drive),
        )
    }
    return {DRIVES: section}


_OF_MASSES = ("reflected_mass_kg", "reflected_mass_worst_kg", "stiffness_least_npm", "damping_least_nspm")


def _extreme(motion: "MotionDrives", figure: "Directed", largest: bool) -> Section:
    row = int(figure.value.argmax() if largest else figure.value.argmin())
    return {"value": float(figure.value[row]), **_where(motion, row), "along": _turned(figure.along[row])}


def _where(motion: "MotionDrives", row: int) -> Section:
    return {"t_s": float(motion.t_s[row]), "s": float(motion.s[row])}


def _turned(direction: "FloatArray") -> list[float]:
    """Return a direction whose largest part is positive."""
    turned: list[float] = (direction * np.sign(direction[np.abs(direction).argmax()])).tolist()
    return turned
