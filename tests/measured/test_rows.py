"""Arrays are checked before they are used."""

import pickle

import numpy as np
import pytest

from pipeline.errors import UsageError
from pipeline.measured.rows import RowError, require_array


def test_what_is_right_is_given_as_floats() -> None:
    """Whole numbers in lists will do."""
    assert require_array("poses", [[1, 2], [3, 4]], (-1, 2)).dtype == float
    assert require_array("poses", np.zeros((0, 2)), (-1, 2)).shape == (0, 2)


@pytest.mark.parametrize(
    ("values", "expected"),
    [
        ([1.0, 2.0], r"poses must have the shape \(n, 2\), not \(2,\)"),
        ([[1.0, 2.0, 3.0]], r"not \(1, 3\)"),
        ([["a", "b"]], "must be real numbers"),
        ([[1j, 2.0]], "must be real numbers"),
        ([[0.0, 1.0], [0.0, np.nan]], "not finite at index 1"),
        ([[np.inf, 1.0]], "not finite at index 0"),
    ],
)
def test_what_is_wrong_is_named(values: object, expected: str) -> None:
    """Another shape, another type and what is not finite are refused."""
    with pytest.raises(UsageError, match=expected):
        require_array("poses", values, (-1, 2))  # type: ignore[arg-type]


def test_errors_of_rows_survive_pickling() -> None:
    """A process pool hands them on."""
    error = pickle.loads(pickle.dumps(RowError("too far", 3)))
    assert (str(error), error.row, error.message) == ("index 3: too far", 3, "too far")
