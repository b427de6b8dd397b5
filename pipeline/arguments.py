"""Arguments of public functions: what a docstring excludes is refused by name, with what was given and expected."""

import math
from typing import Any

import numpy as np

from pipeline.arrays import FloatArray, IntArray
from pipeline.errors import ArgumentError

Shape = tuple[int | str, ...]
"""Lengths of axes; a letter is any length, "..." any number of axes before the others."""
_KINDS = "fiu"
"""What counts as a real number: neither truth values, nor complex numbers, nor texts or objects."""


def require_array(
    name: str, value: object, shape: Shape, *, least: float = -np.inf, largest: float = np.inf, finite: bool = True
) -> FloatArray:
    """Return real numbers of a shape as an array of floats.

    NaN and infinite values are refused unless `finite` is false; so is everything below `least` or above `largest`.

    Raises
    ------
    ArgumentError
        If the argument is something else.
    """
    array = _real(name, value)
    require_shape(name, array, shape)
    if finite and not np.isfinite(array).all():
        raise _wrong(name, array, ~np.isfinite(array), "finite numbers")
    # NaN compares as false.
    if ((array < least) | (array > largest)).any():
        raise _wrong(name, array, (array < least) | (array > largest), _between(least, largest))
    return array


def require_shape(name: str, array: Any, shape: Shape) -> None:
    """Require an array of a shape, without a look at its values.

    Raises
    ------
    ArgumentError
        If it is not an array, or of another shape.
    """
    found = getattr(array, "shape", None)
    if found is None:
        raise ArgumentError(f"{name}: expected an array of shape {_words(shape)}, not {_shown(array)}")
    open_ended = shape[:1] == ("...",)
    axes = shape[1:] if open_ended else shape
    last = found[len(found) - len(axes) :]
    fits = len(found) >= len(axes) if open_ended else len(found) == len(axes)
    if not fits or any(isinstance(want, int) and want != have for want, have in zip(axes, last, strict=True)):
        raise ArgumentError(f"{name}: expected an array of shape {_words(shape)}, not of {found}")


def require_number(
    name: str, value: object, *, least: float = -np.inf, above: float = -np.inf, largest: float = np.inf
) -> float:
    """Return a finite number that is at least `least`, more than `above` and at most `largest`.

    Raises
    ------
    ArgumentError
        If the argument is something else.
    """
    array = _real(name, value)
    if array.shape != ():
        raise ArgumentError(f"{name}: expected a number, not an array of shape {array.shape}")
    number = float(array)
    if not (math.isfinite(number) and least <= number <= largest and (number > above or above == -np.inf)):
        raise ArgumentError(f"{name}: expected {_between(least, largest, above)}, not {number:g}")
    return number


def require_whole(name: str, value: object, least: int, largest: int) -> int:
    """Return a whole number between two others.

    Raises
    ------
    ArgumentError
        If the argument is something else.
    """
    number = require_number(name, value, least=least, largest=largest)
    if number != int(number):
        raise ArgumentError(f"{name}: expected a whole number, not {number:g}")
    return int(number)


def require_whole_numbers(name: str, value: object, least: int, largest: int) -> IntArray:
    """Return whole numbers between two others as an array of any shape.

    Raises
    ------
    ArgumentError
        If the argument is something else.
    """
    array = require_array(name, value, ("...",), least=least, largest=largest)
    if (array != np.floor(array)).any():
        raise _wrong(name, array, array != np.floor(array), "whole numbers")
    return array.astype(np.int64)


def require_one_length(**arrays: Any) -> None:
    """Require arrays with first axes of one length; the keywords are their names.

    Raises
    ------
    ArgumentError
        If two lengths differ.
    """
    lengths = {name: len(array) for name, array in arrays.items()}
    if len(set(lengths.values())) > 1:
        found = ", ".join(f"{name} {length}" for name, length in lengths.items())
        raise ArgumentError(f"expected as many rows of each, not {found}")


def _real(name: str, value: object) -> FloatArray:
    try:
        array = np.asarray(value)
    except ValueError:
        raise ArgumentError(f"{name}: its rows are of different lengths") from None
    if array.dtype.kind not in _KINDS or not np.can_cast(array.dtype, np.float64):
        raise ArgumentError(f"{name}: expected real numbers, not {_shown(value)} ({array.dtype})")
    return np.asarray(array, dtype=float)


def _wrong(name: str, array: FloatArray, wrong: Any, expected: str) -> ArgumentError:
    if array.shape == ():
        return ArgumentError(f"{name}: expected {expected}, not {array:g}")
    place = tuple(int(axis[0]) for axis in np.nonzero(wrong))
    return ArgumentError(f"{name}: expected {expected}, not {array[place]:g} (at [{', '.join(map(str, place))}])")


def _between(least: float, largest: float, above: float = -np.inf) -> str:
    parts = [f"more than {above:g}" if above > -np.inf else "", f"at least {least:g}" if least > -np.inf else ""]
    parts += [f"at most {largest:g}" if largest < np.inf else ""]
    return " ".join(["a finite number", " and ".join(part for part in parts if part)]).strip()


def _words(shape: Shape) -> str:
    return f"({', '.join(map(str, shape))}{',' if len(shape) == 1 else ''})"


def _shown(value: object) -> str:
    text = repr(value)
    return text if len(text) <= 40 else f"{type(value).__name__} {text[:30]}..."
