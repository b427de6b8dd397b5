"""Collect the rows of a linear program as blocks over named groups of columns."""

from collections.abc import Container, Mapping

import numpy as np
from scipy.sparse import block_array, csc_array

from pipeline.arrays import FloatArray
from pipeline.solvers.highs import LinearProgram


class Blocks:
    """Rows low <= A x <= high, where A is put together of blocks, one per group of columns."""

    def __init__(self, sizes: Mapping[str, int]) -> None:
        self._sizes = dict(sizes)
        self._rows: list[tuple[Mapping[str, csc_array], FloatArray, FloatArray]] = []

    def widen(self, name: str, size: int) -> None:
        """Add a group of columns."""
        self._sizes[name] = size

    def add(self, blocks: Mapping[str, csc_array], low: FloatArray | float, high: FloatArray | float) -> None:
        """Add rows; groups that are left out have zeros in them."""
        count = next(iter(blocks.values())).shape[0]
        self._rows.append((blocks, np.broadcast_to(low, count), np.broadcast_to(high, count)))

    def columns(self, name: str) -> slice:
        """Where a group is among all columns."""
        names = list(self._sizes)
        first = sum(self._sizes[before] for before in names[: names.index(name)])
        return slice(first, first + self._sizes[name])

    def program(
        self,
        cost: Mapping[str, FloatArray],
        low: Mapping[str, FloatArray],
        high: Mapping[str, FloatArray],
        integer: Container[str],
    ) -> LinearProgram:
        """Put the program together; groups cost nothing, and are at least 0 and unlimited, unless said otherwise."""
        sizes = self._sizes.items()
        # A row without any entry, so that groups that no row touches still have their columns.
        frame = [csc_array((0, size)) for _, size in sizes]
        table = [[blocks.get(name) for name, _ in sizes] for blocks, _, _ in self._rows]
        return LinearProgram(
            matrix=csc_array(block_array([frame, *table], format="csc")),
            cost=np.concatenate([cost.get(name, np.zeros(size)) for name, size in sizes]),
            column_bounds=(
                np.concatenate([low.get(name, np.zeros(size)) for name, size in sizes]),
                np.concatenate([high.get(name, np.full(size, np.inf)) for name, size in sizes]),
            ),
            row_bounds=(
                np.concatenate([least for _, least, _ in self._rows]),
                np.concatenate([most for _, _, most in self._rows]),
            ),
            integer=np.concatenate([np.full(size, name in integer) for name, size in sizes]),
        )
