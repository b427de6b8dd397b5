"""Arrays in .npz files, and back: what is loaded is exactly what was saved."""

import contextlib
import io
import pathlib
import zipfile
from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np
import numpy.typing as npt

from pipeline.errors import UsageError

Arrays = Mapping[str, npt.NDArray[Any]]


def npz_bytes(arrays: Mapping[str, object]) -> bytes:
    """Write arrays as an .npz file: the same arrays always give the same bytes."""
    buffer = io.BytesIO()
    np.savez(buffer, allow_pickle=False, **{name: np.asarray(array) for name, array in arrays.items()})
    return buffer.getvalue()


def read_npz(path: pathlib.Path) -> dict[str, npt.NDArray[Any]]:
    """Read all arrays of an .npz file.

    Raises
    ------
    UsageError
        When it cannot be read.
    """
    with readable(path), np.load(path, allow_pickle=False) as arrays:
        return dict(arrays)


@contextlib.contextmanager
def readable(path: pathlib.Path) -> Iterator[None]:
    """Name the file in the error if its content cannot be used."""
    try:
        yield
    except (KeyError, ValueError, TypeError, EOFError, zipfile.BadZipFile) as error:
        raise UsageError(
            f"{path} cannot be read ({error}): it may have been written by another version.\n"
            "  What to change: run the pipeline again with --force."
        ) from None
