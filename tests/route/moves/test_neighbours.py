"""Grid cells: what is one step away is found, and nothing farther than two."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from pipeline.route.moves.neighbours import Cells


@given(st.integers(0, 2**32 - 1), st.booleans())
def test_all_that_is_within_one_step_is_found_once(seed, whole):
    """Against brute force: every region of the mode within a step in all coordinates, none two steps off or more."""
    random = np.random.default_rng(seed)
    n = int(random.integers(1, 60))
    coordinates = random.uniform(-2.0, 3.0, (n, 4))
    coordinates = np.round(coordinates) + 0.3 if whole else coordinates
    modes, wanted = random.integers(0, 8, (2, n)) % 3
    number, rows = Cells.of(coordinates, modes).around(np.arange(n), wanted)
    assert number.sum() == len(rows)
    for origin, found in enumerate(np.split(rows, np.cumsum(number)[:-1])):
        apart = np.abs(coordinates - coordinates[origin]).max(axis=1)
        near = np.flatnonzero((apart <= 1.0) & (modes == wanted[origin]))
        assert len(set(found.tolist())) == len(found)
        assert set(near.tolist()) <= set(found.tolist())
        assert (modes[found] == wanted[origin]).all()
        assert (apart[found] < 2.0).all()
        if whole:
            assert set(near.tolist()) == set(found.tolist())
