"""How seconds grow with the number of regions."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from tests.benchmarks.scale import PARTS


def growth(cases: Sequence[Mapping[str, Any]]) -> dict[str, dict[str, Any]]:
    """Fit seconds ~ n^exponent over the cases that have them, and hold them against n log n.

    `n_log_n` are the seconds of every case over n log n, divided by those of the smallest case: above one
    where the cost grew faster than that. Parts that fewer than two cases finished are left out.
    """
    found = {}
    for part in (*PARTS, "total_s"):
        points = sorted((case["regions"], case[part]) for case in cases if part in case)
        if len({n for n, _ in points}) < 2:
            continue
        n, seconds = np.array(points, dtype=float).T
        ratio = seconds / (n * np.log(n))
        exponent = float(np.polyfit(np.log(n), np.log(seconds), 1)[0])
        found[part] = {"exponent": exponent, "regions": n.tolist(), "n_log_n": (ratio / ratio[0]).tolist()}
    return found
