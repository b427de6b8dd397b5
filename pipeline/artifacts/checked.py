"""Arrays of a file as results expect them: there, of the right kind and shape, and within their range."""

from typing import Any

import numpy as np
import numpy.typing as npt

from pipeline.arrays import FloatArray, IntArray
from pipeline.artifacts.npz import Arrays

_WHOLE = "iu"
_NUMBERS = "iuf"


class CheckedArrays:
    """Looks arrays up by name; what is wrong with one is a ValueError that names it.

    Shapes are given by numbers, and by letters for lengths that all arrays with the same letter must share.
    """

    def __init__(self, arrays: Arrays) -> None:
        self._arrays = arrays
        self._lengths: dict[str, tuple[int, str]] = {}

    def floats(self, name: str, *shape: int | str, finite: bool = True) -> FloatArray:
        """Give an array of floating-point numbers; none is NaN, nor infinite unless that is allowed."""
        array = self._array(name, "f", "numbers", shape)
        if np.isnan(array).any() or (finite and not np.isfinite(array).all()):
            raise ValueError(f"{name} has values that are not finite")
        return array

    def whole(self, name: str, *shape: int | str, least: int = 0, most: int | None = None) -> IntArray:
        """Give an array of whole numbers within bounds."""
        array = self._array(name, _WHOLE, "whole numbers", shape)
        if array.size and (int(array.min()) < least or (most is not None and int(array.max()) > most)):
            allowed = f"at least {least}" if most is None else f"from {least} to {most}"
            raise ValueError(f"{name} has values from {array.min()} to {array.max()}; expected {allowed}")
        return array

    def count(self, name: str) -> int:
        """Give a whole number of at least zero."""
        return int(self.whole(name).item())

    def number(self, name: str) -> float:
        """Give a number, which may be infinite or NaN."""
        return float(self._array(name, _NUMBERS, "a number", ()).item())

    def flag(self, name: str) -> bool:
        """Give a truth value."""
        return bool(self._array(name, "b", "a truth value", ()).item())

    def text(self, name: str) -> str:
        """Give a text."""
        return str(self._array(name, "U", "a text", ()).item())

    def __contains__(self, name: str) -> bool:
        return name in self._arrays

    def _array(self, name: str, kinds: str, what: str, shape: tuple[int | str, ...]) -> npt.NDArray[Any]:
        if name not in self._arrays:
            raise ValueError(f"it has no {name}")
        array = self._arrays[name]
        if array.dtype.kind not in kinds:
            raise ValueError(f"{name} is of the type {array.dtype}, not {what}")
        if array.ndim != len(shape):
            raise ValueError(f"{name} has the shape {array.shape}, not {len(shape)} axes")
        for length, wanted in zip(array.shape, shape, strict=True):
            needed, by = self._lengths.setdefault(wanted, (length, name)) if isinstance(wanted, str) else (wanted, "")
            if length != needed:
                of = f", as many as {by}" if by else ""
                raise ValueError(f"{name} has the shape {array.shape}, with {length} where {needed} is expected{of}")
        return array
