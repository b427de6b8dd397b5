"""Arrays in files."""

import io
import zipfile

import numpy as np

from pipeline.artifacts.npz import npz_bytes


def test_same_arrays_same_bytes() -> None:
    """Hashes of results depend on their values alone, not on when they were written."""
    content = npz_bytes({"a": np.arange(5.0), "b": "text"})
    assert npz_bytes({"a": np.arange(5.0), "b": "text"}) == content
    with zipfile.ZipFile(io.BytesIO(content)) as archive:
        assert {entry.date_time for entry in archive.infolist()} == {(1980, 1, 1, 0, 0, 0)}
