"""Moves the paper's rules would admit and ours do not, as rows for the programs that know only its rules."""

from dataclasses import dataclass

import numpy as np

from pipeline.machine.geometry import FloatArray, IntArray
from pipeline.route.grid import gate_bit
from pipeline.route.moves import Moves
from pipeline.route.regions import RegionTable
from pipeline.route.rows import Rows

_ROUNDING = 1e-9
_BLOCK = 2_000


@dataclass(frozen=True, eq=False)
class Exclusions:
    """Ordered pairs of regions that no step may join, sorted by the first.

    Attributes
    ----------
    source, target : (m,)
        Rows of the region table.
    """

    source: IntArray
    target: IntArray

    def __len__(self) -> int:
        return len(self.source)

    def add_rows(self, rows: Rows, before: int, after: int) -> None:
        """Add delta_i-1,j + sum of delta_i,k over the excluded k <= 1 for every j; delta columns start at the offsets.

        With one region per step (12) the sum is at most one, so that a row holds all pairs of its j.
        """
        for j, begin, end in self._groups():
            targets = self.target[begin:end]
            columns = np.concatenate([[before + j], after + targets])
            rows.add("excluded moves", [(columns, np.ones(len(columns)))], -np.inf, 1.0)

    def _groups(self) -> list[tuple[int, int, int]]:
        sources, begin = np.unique(self.source, return_index=True)
        end = np.append(begin[1:], len(self.source))
        return list(zip(sources.tolist(), begin.tolist(), end.tolist(), strict=True))


def excluded_pairs(regions: RegionTable, moves: Moves, steps: FloatArray) -> Exclusions:
    """List the pairs within the largest moves (14)-(17) and the mode rule (38) that are no admitted moves.

    Every pair is looked at: meant for tables of a few thousand regions. `steps` (5,) are the largest moves.
    """
    coordinates = regions.controlled[:, 1:] / steps[1:]
    flip = gate_bit(regions.gate)
    count = len(regions)
    admitted = moves.source.astype(np.int64) * count + moves.target
    sources, targets = [], []
    for begin in range(0, count, _BLOCK):
        block = np.arange(begin, min(begin + _BLOCK, count))
        near = (np.abs(coordinates[block, None] - coordinates[None]) <= 1.0 + _ROUNDING).all(axis=2)
        changed = regions.mode[block, None] ^ regions.mode[None]
        near &= (changed & ~flip[block, None]) == 0
        i, k = np.nonzero(near)
        i = block[i]
        keep = (i != k) & ~np.isin(i * count + k, admitted)
        sources.append(i[keep])
        targets.append(k[keep])
    return Exclusions(np.concatenate(sources), np.concatenate(targets))
