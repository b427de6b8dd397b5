"""Arrays in .npz files, and back: what is loaded is exactly what was saved.

A file is read within its own size: nothing in it is compressed, no array is larger than its bytes, and none holds
objects.
"""

import contextlib
import io
import math
import os
import pathlib
import struct
import zipfile
from collections.abc import Iterator, Mapping
from typing import Any, BinaryIO

import numpy as np
import numpy.typing as npt

from pipeline.errors import UsageError
from pipeline.regular_file import open_regular_file

Arrays = Mapping[str, npt.NDArray[Any]]

MOST_BYTES = 100_000_000
"""Largest file that is read unless more is expected: a path or a trajectory has less than a hundredth of it."""
_MOST_ARRAYS = 100
_KINDS = "biufU"
"""Truth values, whole numbers, floating-point numbers and text."""
_HEADERS = {(1, 0): np.lib.format.read_array_header_1_0, (2, 0): np.lib.format.read_array_header_2_0}
_ENCRYPTED = 1
_DAMAGED = (
    ArithmeticError,
    EOFError,
    LookupError,
    OSError,
    RuntimeError,
    TypeError,
    ValueError,
    struct.error,
    zipfile.BadZipFile,
)
"""What the zipfile module and NumPy raise for files that are none of theirs."""


def npz_bytes(arrays: Mapping[str, object]) -> bytes:
    """Write arrays as an .npz file: the same arrays always give the same bytes."""
    buffer = io.BytesIO()
    np.savez(buffer, allow_pickle=False, **{name: np.asarray(array) for name, array in arrays.items()})
    return buffer.getvalue()


def read_npz(path: pathlib.Path, most_bytes: float = MOST_BYTES) -> dict[str, npt.NDArray[Any]]:
    """Read all arrays of an .npz file of at most so many bytes.

    Raises
    ------
    UsageError
        When it is damaged, compressed, encrypted, or holds anything but numbers and text.
    OSError
        When there is no such file, or it is no regular file or too large.
    """
    with open_regular_file(path, int(most_bytes)) as file, readable(path):
        try:
            return _read_archive(file)
        except _DAMAGED as error:
            raise ValueError(str(error) or type(error).__name__) from None


@contextlib.contextmanager
def readable(path: pathlib.Path) -> Iterator[None]:
    """Name the file in the error if its content cannot be used."""
    try:
        yield
    except (LookupError, ValueError, TypeError, ArithmeticError) as error:
        raise UsageError(
            f"{path} cannot be read ({error}): it is damaged, of another kind or of another version.\n"
            "  What to change: run the pipeline again with --force."
        ) from None


def _read_archive(file: BinaryIO) -> dict[str, npt.NDArray[Any]]:
    size = os.fstat(file.fileno()).st_size
    with zipfile.ZipFile(file) as archive:
        members = archive.infolist()
        if len(members) > _MOST_ARRAYS or len({member.filename for member in members}) < len(members):
            raise ValueError(f"it has {len(members):,} entries, more than are written or some of them twice")
        for member in members:
            if member.compress_type != zipfile.ZIP_STORED or member.flag_bits & _ENCRYPTED:
                raise ValueError(f"{member.filename} is compressed or encrypted")
        if sum(member.file_size for member in members) > size:
            raise ValueError("its entries are larger than the file")
        return {member.filename.removesuffix(".npy"): _read_array(archive, member) for member in members}


def _read_array(archive: zipfile.ZipFile, member: zipfile.ZipInfo) -> npt.NDArray[Any]:
    """Read an array that is exactly as large as its header says."""
    with archive.open(member) as file:
        version = np.lib.format.read_magic(file)
        if version not in _HEADERS:
            raise ValueError(f"{member.filename} is of the unknown version {version}")
        shape, by_columns, dtype = _HEADERS[version](file)
        if dtype.kind not in _KINDS or not dtype.isnative:
            raise ValueError(f"{member.filename} has values of the type {dtype}")
        content = bytearray(file.read())
    if math.prod(shape) * dtype.itemsize != len(content):
        raise ValueError(f"{member.filename} has {len(content):,} bytes, which its shape {shape} does not fit")
    return np.ndarray(shape, dtype, content, order="F" if by_columns else "C")
