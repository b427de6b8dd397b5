"""The sequence of working modes along s: on which side of the platform every cart has to be."""

import numpy as np

from pipeline.arrays import FloatArray, IntArray
from pipeline.machine.geometry import MODE_SIGNS
from pipeline.refine.coarse import corner_parameters
from pipeline.refine.result import Path
from pipeline.route.result import Route


def sides_at(route: Route, coarse: Path, s: FloatArray) -> FloatArray:
    """Return the side of every arm at s (n,): 1 for mode R, -1 for L, 0 where the arm may change. Shape (n, 3).

    An arm may change from half-way after the change before to half-way before the next one, of whichever arm: every
    change finds its own best place, and their order stays that of the route. Where one arm changes back and forth, half
    of that is free on either side of the change; in the other half the arm keeps the mode in between.
    """
    moves, arms = np.nonzero(np.diff(MODE_SIGNS[route.modes], axis=0))
    place = corner_parameters(coarse)[_gate_steps(route, moves, arms)]
    places = np.unique(place)
    edges = np.concatenate([[0.0], (places[1:] + places[:-1]) / 2.0, [1.0]])
    sides = np.tile(MODE_SIGNS[route.modes[0]], (len(s), 1))
    for move, arm, at in zip(moves, arms, place, strict=True):
        nth, of_arm = int(np.searchsorted(places, at)), place[arms == arm]
        begin, end = edges[nth], edges[nth + 1]
        if nth > 0 and places[nth - 1] in of_arm:
            begin = (begin + at) / 2.0
        if nth + 1 < len(places) and places[nth + 1] in of_arm:
            end = (end + at) / 2.0
        sides[(s > begin) & (s < end), arm] = 0.0
        sides[s >= end, arm] = MODE_SIGNS[route.modes[move + 1], arm]
    return sides


def _gate_steps(route: Route, moves: IntArray, arms: IntArray) -> IntArray:
    """Return the steps of the route at whose gates the arms change: before or after the moves they change in."""
    return np.asarray(np.where(route.gates[moves] == arms + 1, moves, moves + 1))
