"""Choice of the working mode at gates."""

import itertools
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pipeline.route.search.gate_modes import fewest_mode_changes

BIT = {0: 0, 1: 4, 2: 2, 3: 1}


@pytest.fixture(scope="module")
def gates(hand_table):
    """Give a function that makes a way of places, each in all the modes that a gate there may have, and its rows."""

    def make(seed):
        random = np.random.default_rng(seed)
        places, rows, table = int(random.integers(3, 8)), [], []
        mode = 0
        for place in range(places):
            gate = int(random.integers(0, 4)) if 0 < place < places - 1 else 0
            table += [(place, gate, mode), (place, gate, mode ^ BIT[gate])] if gate else [(place, gate, mode)]
            if gate and random.random() < 0.7:
                mode ^= BIT[gate]
                rows.append(len(table) - 1 - int(random.random() < 0.5))
                # Whichever mode it arrives in, it may leave in the other.
            else:
                rows.append(len(table) - (2 if gate else 1))
        place, gate, modes = np.array(table).T
        regions = hand_table([(0.0, 1.0)] * len(table), np.ones(len(table)))
        controlled = np.zeros((len(table), 5))
        controlled[:, 1] = place
        regions = replace(regions, gates=gate, modes=modes, controlled=controlled)
        return regions, np.array(rows)

    return make


def _valid(regions, rows):
    pairs = itertools.pairwise(rows)
    return all(not (regions.modes[i] ^ regions.modes[j]) & ~BIT[int(regions.gates[i])] for i, j in pairs)


def _changes(regions, rows):
    return sum(int(regions.modes[i] ^ regions.modes[j]).bit_count() for i, j in itertools.pairwise(rows))


@given(st.integers(0, 1_000_000))
def test_the_fewest_changes_are_taken(gates, seed):
    """By brute force over both modes of every gate; places stay, and (38) holds."""
    regions, rows = gates(seed)
    if not _valid(regions, rows):
        return
    fewer = fewest_mode_changes(regions, rows)
    assert _valid(regions, fewer)
    np.testing.assert_array_equal(regions.controlled[fewer], regions.controlled[rows])
    places = [np.flatnonzero(regions.controlled[:, 1] == regions.controlled[row, 1]) for row in rows]
    fewest = min(_changes(regions, way) for way in itertools.product(*places) if _valid(regions, way))
    assert _changes(regions, fewer) == fewest


def test_a_flip_that_leads_nowhere_goes(gates, hand_table):
    """At a gate of arm 1 into the other mode and back again: no change at all; a visit stays in its mode."""
    regions = hand_table([(0.0, 1.0)] * 5, np.ones(5))
    controlled = np.zeros((5, 5))
    controlled[:, 1] = [1, 1, 2, 0, 3]
    table = replace(regions, gates=np.array([1, 1, 1, 0, 0]), modes=np.array([0, 4, 4, 0, 0]), controlled=controlled)
    assert fewest_mode_changes(table, np.array([3, 0, 1, 2, 4])).tolist() == [3, 0, 0, 2, 4]
    visited = replace(table, visits=np.array([0, 1, 0, 0, 0]))
    assert fewest_mode_changes(visited, np.array([3, 0, 1, 2, 4])).tolist() == [3, 0, 1, 2, 4]
