"""Choice of the working mode at gates: both modes have the same pose and cost, so the fewest changes are taken."""

import numpy as np

from pipeline.arrays import IntArray
from pipeline.route.regions.gates import gate_bit
from pipeline.route.regions.table import RegionTable


def fewest_mode_changes(regions: RegionTable, rows: IntArray) -> IntArray:
    """Exchange gates (n,) of a route for their twins in the other mode of the arm where that saves mode changes.

    A dynamic program over the steps; visits stay as they are. Shape (n,).
    """
    options = [[row, *_twins(regions, row)] for row in rows.tolist()]
    # For every option of a step: fewest changes up to it, and the options taken so far.
    best: list[tuple[int, list[int]]] = [(0, [row]) for row in options[0]]
    for ahead in options[1:]:
        best = [
            min(
                (changes + _changes(regions, taken[-1], row), [*taken, row])
                for changes, taken in best
                if _admitted(regions, taken[-1], row)
            )
            for row in ahead
            if any(_admitted(regions, taken[-1], row) for _, taken in best)
        ]
    return np.array(min(best, key=lambda option: option[0])[1])


def _twins(regions: RegionTable, row: int) -> list[int]:
    """Find the same gate in the other working mode of its arm; none where the region is not a gate, or is a visit."""
    gate = regions.gates[row]
    if gate == 0 or regions.visits[row] > 0:
        return []
    other = regions.modes[row] ^ gate_bit(regions.gates[[row]])[0]
    same = np.flatnonzero((regions.gates == gate) & (regions.modes == other) & (regions.visits == 0))
    same = same[(regions.controlled[same] == regions.controlled[row]).all(axis=1)]
    return list(same[(regions.x_window_m[same] == regions.x_window_m[row]).all(axis=1)].tolist())


def _changes(regions: RegionTable, here: int, there: int) -> int:
    return int(regions.modes[here] ^ regions.modes[there]).bit_count()


def _admitted(regions: RegionTable, here: int, there: int) -> bool:
    """Check (38): only the arm of a gate may change, and only on leaving it."""
    free = gate_bit(regions.gates[[here]])[0]
    return not (regions.modes[here] ^ regions.modes[there]) & ~free
