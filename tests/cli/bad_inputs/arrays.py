"""Damaged .npz files: what happens to files, and what somebody could do to them."""

import io
import zipfile
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
import pytest

from pipeline.artifacts.npz import npz_bytes

Damage = Callable[[bytes], bytes]


def _arrays(content: bytes) -> dict[str, Any]:
    with np.load(io.BytesIO(content)) as arrays:
        return dict(arrays)


def _changed(change: Callable[[dict[str, Any]], Mapping[str, Any]]) -> Damage:
    return lambda content: npz_bytes(change(_arrays(content)))


def _of_each(change: Callable[[Any], Any]) -> Damage:
    return _changed(lambda arrays: {name: change(array) for name, array in arrays.items()})


def _compressed(content: bytes) -> bytes:
    buffer = io.BytesIO()
    np.savez_compressed(buffer, **_arrays(content))
    return buffer.getvalue()


def _objects(content: bytes) -> bytes:
    buffer = io.BytesIO()
    np.savez(buffer, **{name: np.array([None], dtype=object) for name in _arrays(content)})
    return buffer.getvalue()


def _bomb(content: bytes) -> bytes:
    """Give two arrays 10 MB of zeros, in a file of some kilobytes."""
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w", zipfile.ZIP_DEFLATED, compresslevel=1) as archive:
        for name in list(_arrays(content))[:2]:
            archive.writestr(f"{name}.npy", bytes(10**7))
    return buffer.getvalue()


def _huge_shape(content: bytes) -> bytes:
    """Say in the header of an array that there are 10^15 numbers."""
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w") as archive:
        for name in _arrays(content):
            array = io.BytesIO()
            np.lib.format.write_array_header_1_0(array, {"descr": "<f8", "fortran_order": False, "shape": (10**15,)})
            archive.writestr(f"{name}.npy", array.getvalue())
    return buffer.getvalue()


def _flag(offset: int, signature: bytes, bits: int) -> Damage:
    """Set bits of every header in the archive."""

    def damage(content: bytes) -> bytes:
        changed = bytearray(content)
        at = changed.find(signature)
        while at >= 0:
            changed[at + offset] |= bits
            at = changed.find(signature, at + 4)
        return bytes(changed)

    return damage


def _twice(content: bytes) -> bytes:
    buffer = io.BytesIO(content)
    name = next(iter(_arrays(content)))
    with zipfile.ZipFile(buffer, "a") as archive, pytest.warns(UserWarning, match="Duplicate name"):
        archive.writestr(f"{name}.npy", b"")
    return buffer.getvalue()


def _many(content: bytes) -> bytes:
    return npz_bytes({**_arrays(content), **{f"more_{k}": 0 for k in range(101)}})


DAMAGES: dict[str, Damage] = {
    "empty": lambda content: b"",
    "first half": lambda content: content[: len(content) // 2],
    "second half": lambda content: content[len(content) // 2 :],
    "zeros": lambda content: bytes(len(content)),
    "text": lambda content: b"PK\x03\x04 no archive",
    "one array": lambda content: content[content.index(b"\x93NUMPY") :][:500],
    "a bit of the data": lambda content: content.replace(b"\x93NUMPY", b"\x93NUMPX"),
    "compressed": _compressed,
    "bomb": _bomb,
    "huge shape": _huge_shape,
    "encrypted": _flag(8, b"PK\x01\x02", 1),
    "unknown method": _flag(10, b"PK\x01\x02", 99),
    "objects": _objects,
    "an entry twice": _twice,
    "many entries": _many,
    "no arrays": _changed(lambda arrays: {}),
    "all but one array": _changed(lambda arrays: dict(list(arrays.items())[1:])),
    "complex": _of_each(lambda array: array.astype(complex) if array.dtype.kind == "f" else array),
    "single precision of the other byte order": _of_each(
        lambda array: array.astype(">f4") if array.dtype.kind == "f" else array
    ),
    "texts": _of_each(lambda array: array.astype(str)),
    "one more axis": _of_each(lambda array: array[None]),
    "half the rows": _of_each(lambda array: array[: len(array) // 2] if array.ndim else array),
    "no rows": _of_each(lambda array: array[:0] if array.ndim else array),
    "one row less of one": _changed(
        lambda arrays: {**arrays, (name := max(arrays, key=lambda n: arrays[n].size)): arrays[name][:-1]}
    ),
    "nan": _of_each(lambda array: array * np.nan if array.dtype.kind == "f" and array.ndim else array),
    "inf": _of_each(lambda array: array + np.inf if array.dtype.kind == "f" and array.ndim else array),
    "negative": _of_each(lambda array: -array - 1 if array.dtype.kind in "iuf" else array),
    "backwards": _of_each(lambda array: array[::-1] if array.ndim == 1 and array.dtype.kind == "f" else array),
}
"""Ways to damage the content of a file; every reader refuses every result."""
