"""Measurements in another unit, or of the other direction, recognised before errors are computed from them."""

import numpy as np

from pipeline.arrays import FloatArray
from pipeline.measured.rows import RowError

LENGTHS = {"millimetres": 1e3, "centimetres": 1e2, "micrometres": 1e6, "inches": 1.0 / 0.0254}
"""Other units of length, by what a value in metres is multiplied with."""
_ANGLES = {"degrees": 180.0 / np.pi, "milliradians": 1e3}
_LIKE = 0.1
"""Largest relative difference from a factor between units."""
_SMALLEST = {"m": 0.1, "rad": 0.02}
"""Commanded values, by unit, below which a ratio means nothing."""
_CLEARLY = 10.0
"""How much nearer to what is expected in reverse a motion has to be to be the way back."""


def require_units(names: tuple[str, ...], measured: FloatArray, expected: FloatArray) -> None:
    """Require that columns (n, k), whose names end in their units, are not in another unit than expected (n, k).

    A column is in another unit where the median ratio of measured to expected values is the factor between units.

    Raises
    ------
    RowError
        When they are; names the columns, the unit and the factor.
    """
    found: dict[tuple[str, float], list[str]] = {}
    for name, values, wanted in zip(names, measured.T, expected.T, strict=True):
        unit = name.rsplit("_", 1)[1]
        large = np.abs(wanted) > _SMALLEST[unit]
        if not large.any():
            continue
        ratio = float(np.median(values[large] / wanted[large]))
        for other, factor in (LENGTHS if unit == "m" else _ANGLES).items():
            if abs(ratio / factor - 1.0) < _LIKE:
                found.setdefault((other, factor), []).append(name)
    if found:
        each = [f"{', '.join(columns)}: values look like {other}" for (other, _), columns in found.items()]
        factors = " and ".join(f"those in {other} by {factor:.10g}" for other, factor in found)
        raise RowError(f"{'; '.join(each)}.\n  What to change: divide {factors}.", 0)


def require_direction(measured: FloatArray, expected: FloatArray) -> None:
    """Require that positions (n, k) do not run from the end of what is expected (n, k) to its start.

    Motions that end where they start are told by their course: that of the way back is the same rows reversed.

    Raises
    ------
    RowError
        When both their ends are ten times nearer to the opposite ends, or all rows together to those reversed.
    """

    def is_nearer_reversed(rows: slice) -> bool:
        here, there = (np.linalg.norm((measured - wanted)[rows]) for wanted in (expected, expected[::-1]))
        return bool(_CLEARLY * there < here)

    ends = is_nearer_reversed(slice(1)) and is_nearer_reversed(slice(-1, None))
    if ends or is_nearer_reversed(slice(None)):
        raise RowError(
            "the measurement runs from where the commanded motion ends to where that starts: it is the other "
            "way.\n  What to change: give --back for the way back, and leave it out for the way there.",
            0,
        )
