"""Collect the rows of a linear program one equation at a time, and count them by name."""

from collections import Counter
from dataclasses import dataclass, field

import numpy as np
from scipy.sparse import coo_array, csc_array

from pipeline.arrays import FloatArray, IntArray

Term = tuple[IntArray, FloatArray]
"""Columns and their coefficients."""


@dataclass(eq=False)
class Rows:
    """Rows low <= A x <= high over a given number of columns, in the order they were added."""

    columns: int
    counts: Counter[str] = field(default_factory=Counter)
    _entries: list[tuple[IntArray, IntArray, FloatArray]] = field(default_factory=list)
    _bounds: list[tuple[FloatArray, FloatArray]] = field(default_factory=list)
    _size: int = 0

    def add(self, name: str, terms: list[Term], low: float, high: float) -> None:
        """Add one row: the sum of all terms."""
        for columns, coefficients in terms:
            self._entries.append((np.full(len(columns), self._size), columns, coefficients))
        self._close(name, np.array([low]), np.array([high]))

    def add_each(self, name: str, terms: list[Term], low: float, high: float) -> None:
        """Add a row for every position of the terms, which are equally long."""
        count = len(terms[0][0])
        rows = self._size + np.arange(count)
        for columns, coefficients in terms:
            self._entries.append((rows, columns, coefficients))
        self._close(name, np.full(count, low), np.full(count, high))

    def _close(self, name: str, low: FloatArray, high: FloatArray) -> None:
        self._bounds.append((low, high))
        self._size += len(low)
        self.counts[name] += len(low)

    def matrix(self) -> tuple[csc_array, tuple[FloatArray, FloatArray]]:
        """The matrix, and the least and largest values of its rows."""
        row, column, value = (np.concatenate(parts) for parts in zip(*self._entries, strict=True))
        low, high = (np.concatenate(parts) for parts in zip(*self._bounds, strict=True))
        return csc_array(coo_array((value, (row, column)), shape=(self._size, self.columns))), (low, high)
