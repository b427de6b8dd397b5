"""Errors of rows say which row it is."""

import pickle

from pipeline.measured.rows import RowError


def test_errors_of_rows_survive_pickling() -> None:
    """A process pool hands them on."""
    error = pickle.loads(pickle.dumps(RowError("too far", 3)))
    assert (str(error), error.row, error.message) == ("index 3: too far", 3, "too far")
