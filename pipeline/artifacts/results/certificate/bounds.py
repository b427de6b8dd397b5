"""The bounds of a certificate as JSON: each key states one or both sides of its quantities."""

from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np

from pipeline.certify.bounds import Bounds, Ranges
from pipeline.limits import CertificateKey, Side


def state_bounds(bounds: Bounds, keys: Iterable[CertificateKey]) -> dict[str, Any]:
    """Arrange bounds by their keys."""
    stated = {key.name: _state(key, bounds.ranges[key.name]) for key in keys if key.name in bounds.ranges}
    return {**stated, "kappa_s": bounds.kappa_s, "start_miss": bounds.start_miss, "goal_miss": bounds.goal_miss}


def read_bounds(stated: Mapping[str, Any], keys: Iterable[CertificateKey]) -> Bounds:
    """Read bounds as they are stated."""
    ranges = {key.name: _read(key, stated[key.name]) for key in keys if key.name in stated}
    return Bounds(ranges, stated["kappa_s"], stated["start_miss"], stated["goal_miss"])


def _state(key: CertificateKey, ranges: Ranges) -> object:
    values = [_side_of(key.side, least, largest) for least, largest in ranges.values.tolist()]
    return values[0] if key.subjects == () else dict(zip(ranges.subjects, values, strict=True))


def _read(key: CertificateKey, stated: Any) -> Ranges:
    section = {key.name: stated} if key.subjects == () else stated
    rows = [_both_sides(key.side, value) for value in section.values()]
    return Ranges(tuple(section), np.array(rows, dtype=float).reshape(-1, 2))


def _side_of(side: Side, least: float, largest: float) -> float | int | list[float]:
    match side:
        case Side.SIGN:
            return int(least) if least == largest else 0
        case Side.BOTH:
            return [least, largest]
        case Side.LARGEST:
            return largest
        case Side.LEAST | Side.FLOOR:
            return least


def _both_sides(side: Side, stated: Any) -> tuple[float, float]:
    match side:
        case Side.SIGN:
            return stated, stated
        case Side.BOTH:
            return stated[0], stated[1]
        case Side.LARGEST:
            return -np.inf, stated
        case Side.LEAST | Side.FLOOR:
            return stated, np.inf
