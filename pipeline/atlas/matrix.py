"""The atlas as matrices: a figure of every route or motion, or a few words why there is none."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from pipeline.arrays import FloatArray
from pipeline.atlas.record import AtlasRecord, PairRecord
from pipeline.status import Status
from pipeline.summary.objective_words import ROUTE_QUANTITIES

_WORDS = {
    Status.OPTIMAL: "",
    Status.UNPROVEN: "not proven",
    Status.INFEASIBLE: "no route",
    Status.TIME_LIMIT: "time limit",
    "impossible": "impossible",
}
"""A status in a cell; others are failures."""


@dataclass(frozen=True, eq=False)
class Matrix:
    """A figure of all pairs.

    Attributes
    ----------
    title : str
        What it is, with its unit.
    names : list of str
        The stations: rows are where motions begin, columns where they end.
    values : (s, s)
        The figure; NaN where there is none.
    texts : list of list of str
        What stands in every cell; empty on the diagonal.
    """

    title: str
    names: list[str]
    values: FloatArray
    texts: list[list[str]]


@dataclass(frozen=True)
class _Quantity:
    title: str
    digits: int
    value: Callable[[PairRecord], float | None]


def matrices(record: AtlasRecord) -> list[Matrix]:
    """Give the objective of the routes and, where there are motions, their largest kappa and their duration."""
    objective = ROUTE_QUANTITIES[record.objective_kind]
    quantities = [_Quantity(f"route: {objective.heading}", objective.digits, lambda pair: pair.objective)]
    quantities += [
        quantity for quantity in _OF_MOTIONS if any(quantity.value(pair) is not None for pair in record.pairs)
    ]
    return [_matrix(record, quantity) for quantity in quantities]


def _of_motion(key: str) -> Callable[[PairRecord], float | None]:
    return lambda pair: None if pair.motion is None else getattr(pair.motion, key)


_OF_MOTIONS = (
    _Quantity("path: kappa integral", 1, _of_motion("kappa_integral")),
    _Quantity("path: largest kappa, proven", 2, _of_motion("kappa_bound")),
    _Quantity("motion: duration (s)", 2, _of_motion("duration_s")),
)


def _matrix(record: AtlasRecord, quantity: _Quantity) -> Matrix:
    names, size = record.names, len(record.names)
    values, texts = np.full((size, size), np.nan), [[""] * size for _ in names]
    for origin, target in record.wanted():
        texts[names.index(origin)][names.index(target)] = "not yet"
    for pair in record.pairs:
        row, column = names.index(pair.origin), names.index(pair.target)
        value = quantity.value(pair)
        values[row, column] = np.nan if value is None else value
        texts[row][column] = why_missing(pair) if value is None else f"{value:.{quantity.digits}f}{_mark(pair)}"
    return Matrix(quantity.title, names, values, texts)


def _mark(pair: PairRecord) -> str:
    return "" if pair.is_proven else " ?"


def why_missing(pair: PairRecord) -> str:
    """Say in two words why a figure of a pair is missing."""
    if pair.motion is not None and pair.motion.status != "done":
        return f"{pair.motion.to} failed" if pair.motion.to else "failed"
    return _WORDS.get(pair.status, "failed") or "not asked for"
