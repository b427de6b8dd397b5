"""Moves that the paper's rules would admit and ours do not, as rows for the programs that know only its rules."""

import numpy as np

from pipeline.config import Config
from pipeline.route.moves.candidates import Moves, rule_moves
from pipeline.route.programs.rows import Rows
from pipeline.route.regions.table import RegionTable


def add_exclusions(rows: Rows, excluded: Moves, before: int, after: int) -> None:
    """Add delta_i-1,j + sum of delta_i,k over the excluded k <= 1 for every j; delta columns start at the offsets.

    With one region per step (12) the sum is at most one, so that a row holds all pairs of its j.
    """
    if len(excluded) == 0:
        return
    sources, begin = np.unique(excluded.source, return_index=True)
    end = np.append(begin[1:], len(excluded))
    for j, first, last in zip(sources.tolist(), begin.tolist(), end.tolist(), strict=True):
        columns = np.concatenate([[before + j], after + excluded.target[first:last]])
        rows.add("excluded moves", [(columns, np.ones(len(columns)))], -np.inf, 1.0)


def excluded_pairs(config: Config, regions: RegionTable, moves: Moves) -> Moves:
    """List the pairs that (14)-(17) and (38) admit but that are not admitted moves."""
    by_rule = rule_moves(config, regions)
    count = len(regions)
    keys = by_rule.source.astype(np.int64) * count + by_rule.target
    admitted = moves.source.astype(np.int64) * count + moves.target
    excluded = np.setdiff1d(keys, admitted, assume_unique=True)
    return Moves(excluded // count, excluded % count)
