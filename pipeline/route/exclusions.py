"""Moves the paper's rules would admit and ours do not, as rows for the programs that know only its rules."""

from dataclasses import dataclass

import numpy as np

from pipeline.config import Config
from pipeline.machine.geometry import IntArray
from pipeline.route.moves import Moves, rule_moves
from pipeline.route.regions import RegionTable
from pipeline.route.rows import Rows


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


def excluded_pairs(config: Config, regions: RegionTable, moves: Moves) -> Exclusions:
    """List the pairs that (14)-(17) and (38) admit but that are no admitted moves."""
    by_rule = rule_moves(config, regions)
    count = len(regions)
    keys = by_rule.source.astype(np.int64) * count + by_rule.target
    admitted = moves.source.astype(np.int64) * count + moves.target
    excluded = np.setdiff1d(keys, admitted, assume_unique=True)
    return Exclusions(excluded // count, excluded % count)
