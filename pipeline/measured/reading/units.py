"""Lines of units above or below a header: skipped where they agree with the names, refused where they do not."""

from pipeline.measured.reading.cells import clean, is_gap

_ALIASES = {
    "s": ("s", "sec", "secs", "second", "seconds"),
    "ms": ("ms", "msec", "millisecond", "milliseconds"),
    "us": ("us", "\u00b5s", "\u03bcs", "microseconds"),
    "min": ("min", "minutes"),
    "h": ("h", "hours"),
    "m": ("m", "meter", "meters", "metre", "metres"),
    "mm": ("mm", "millimeter", "millimeters", "millimetre", "millimetres"),
    "cm": ("cm", "centimeters", "centimetres"),
    "um": ("um", "\u00b5m", "\u03bcm", "micron", "microns", "micrometers", "micrometres"),
    "in": ("in", "inch", "inches", '"'),
    "ft": ("ft", "foot", "feet"),
    "rad": ("rad", "radian", "radians"),
    "mrad": ("mrad", "milliradians"),
    "deg": ("deg", "degree", "degrees", "\u00b0"),
}
_UNITS = {alias: unit for unit, aliases in _ALIASES.items() for alias in aliases}


def units_of(cells: list[str], columns: dict[str, int]) -> dict[str, str]:
    """Read the units of columns from a line of units; nothing if the line is not one.

    A line of units has a unit or nothing in each of the columns, in brackets or not, and at least two units.
    """
    units = {}
    for name, index in columns.items():
        text = clean(cells[index]).strip("[]()").strip().casefold() if index < len(cells) else ""
        if text in _UNITS:
            units[name] = _UNITS[text]
        elif not is_gap(text):
            return {}
    return units if len(units) > 1 else {}


def wrong_unit(units: dict[str, str]) -> tuple[str, str, str] | None:
    """Find a column whose name ends in another unit: its name, the unit given, and the unit of the name."""
    for name, unit in units.items():
        if unit != (expected := name.rsplit("_", 1)[1]):
            return name, unit, expected
    return None
