"""Types of arrays: of floats, whole numbers and truth values; their shapes are in the docstrings. And their hash."""

import hashlib
from collections.abc import Mapping
from typing import Any

import numpy as np
import numpy.typing as npt

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.signedinteger[Any]]
BoolArray = npt.NDArray[np.bool_]


def arrays_sha256(head: str, arrays: Mapping[str, npt.ArrayLike]) -> str:
    """Hash arrays bit by bit after a line of text: each by its name, type and shape, so that no others have the bytes.

    Bytes are those of little-endian numbers on every processor.
    """
    digest = hashlib.sha256(f"{head}\n".encode())
    for name, value in arrays.items():
        array = np.ascontiguousarray(value)
        digest.update(f"{name} {array.dtype.kind}{array.dtype.itemsize} {array.shape}\n".encode())
        digest.update(array.astype(array.dtype.newbyteorder("<")).tobytes())
    return digest.hexdigest()
