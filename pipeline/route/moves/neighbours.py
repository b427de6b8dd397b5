"""Regions sorted into grid cells, where those at most one step away from a region are found by a table look-up."""

from dataclasses import dataclass

import numpy as np

from pipeline.arrays import FloatArray, IntArray
from pipeline.machine.geometry import MODES
from pipeline.route.metric import ROUNDING


@dataclass(frozen=True, eq=False)
class Cells:
    """Regions sorted by working mode and grid cell.

    Attributes
    ----------
    order : (n,)
        Rows of the regions, sorted.
    first : (8 cells + 1,)
        Where in `order` each cell of each working mode begins.
    cell : (n,)
        Number of every region's cell, without its working mode.
    count : int
        Number of cells.
    offsets : (27,)
        From a cell's number to those of the cells around it in y, z and rx; along rz, numbers are consecutive.
    """

    order: IntArray
    first: IntArray
    cell: IntArray
    count: int
    offsets: IntArray

    @classmethod
    def of(cls, coordinates: FloatArray, modes: IntArray) -> "Cells":
        """Sort regions in working modes (n,) at y, z, rx, rz (n, 4), counted in steps."""
        cells = np.floor(coordinates - coordinates.min(axis=0) + ROUNDING).astype(np.int64)
        # With an empty rim on every side, neighbours need no bounds checks.
        shape = tuple(cells.max(axis=0) + 3)
        count = int(np.prod(shape))
        cell = np.ravel_multi_index(tuple(cells.T + 1), shape)
        key = modes * count + cell
        first = np.concatenate([[0], np.cumsum(np.bincount(key, minlength=len(MODES) * count))])
        strides = np.array([np.prod(shape[axis + 1 :]) for axis in range(3)])
        offsets = np.stack(np.meshgrid(*[[-1, 0, 1]] * 3, indexing="ij"), axis=-1).reshape(-1, 3) @ strides
        return cls(np.argsort(key, kind="stable").astype(np.int32), first.astype(np.int32), cell, count, offsets)

    @property
    def candidates(self) -> float:
        """Number of regions in and around the cell of a region, on average."""
        crowd = np.diff(self.first).astype(float)
        return 3.0 * len(self.offsets) * float((crowd**2).sum()) / max(len(self.order), 1)

    def around(self, rows: IntArray, modes: IntArray) -> tuple[IntArray, IntArray]:
        """Find all regions in and around the cells of `rows` (k,), for each in its working mode of `modes` (k,).

        Returns how many there are for each (k,), and their rows, concatenated.
        """
        line = (modes * self.count + self.cell[rows])[:, None] + self.offsets
        first = self.first[line - 1]
        number = self.first[line + 2] - first
        flat = number.ravel()
        shift = first.ravel() - (np.cumsum(flat) - flat)
        return number.sum(axis=1), self.order[np.arange(flat.sum()) + np.repeat(shift, flat)]
