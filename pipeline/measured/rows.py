"""Rows of measurements: arrays as this package takes them, and errors that say which row is the reason."""

import numpy as np
import numpy.typing as npt

from pipeline.arrays import FloatArray
from pipeline.errors import UsageError


class RowError(UsageError):
    """A measurement cannot be used because of a row, whose index is `row`; `message` is the text without it."""

    def __init__(self, message: str, row: int) -> None:
        super().__init__(message, row)
        self.message = message
        self.row = row

    def __str__(self) -> str:
        return f"index {self.row}: {self.message}"


def require_array(what: str, values: npt.ArrayLike, shape: tuple[int, ...]) -> FloatArray:
    """Give values as floats of a shape, in which a first size of -1 stands for any.

    Raises
    ------
    UsageError
        When they have another shape, are not real numbers, or not finite; names them as `what`.
    """
    array = np.asarray(values)
    if array.ndim != len(shape) or any(size not in (-1, given) for size, given in zip(shape, array.shape, strict=True)):
        expected = ", ".join("n" if size == -1 else str(size) for size in shape)
        raise UsageError(f"{what} must have the shape ({expected}), not {array.shape}")
    if array.dtype.kind not in "iuf":
        raise UsageError(f"{what} must be real numbers, not of type {array.dtype}")
    if not (finite := np.isfinite(array).all(axis=tuple(range(1, array.ndim)))).all():
        raise UsageError(f"{what} are not finite at index {int(np.argmin(finite))}")
    return array.astype(float)
