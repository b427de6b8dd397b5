"""Intervals of x that obstacles exclude: against distances at many x, and what is left of windows."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pipeline.config import Config
from pipeline.machine import Machine, build_machine
from pipeline.machine.bodies.distances import body_distances
from pipeline.machine.bodies.intervals import excluded_shifts, free_pieces, longest_free
from pipeline.machine.samples import PoseSamples
from pipeline.machine.shapes.model import Bodies
from pipeline.machine.shapes.obstacles import build_obstacles

OBSTACLES = [
    {"name": "workpiece", "box": {"centre_m": [1.0, -0.1, 0.7], "size_m": [0.4, 0.3, 0.3], "rounding_m": 0.01}},
    {"name": "post", "capsule": {"from_m": [1.6, 0.5, -0.2], "to_m": [1.6, 0.5, 1.5], "radius_m": 0.03}},
    {"name": "wedge", "hull": {"points_m": [[0.2, 0.1, 0.4], [0.6, 0.1, 0.4], [0.4, 0.4, 0.5], [0.4, 0.2, 0.9]]}},
]
WINDOW = np.array([0.0, 2.1])


@pytest.fixture(scope="module")
def scene(bodies_config: Config, vary) -> tuple[Bodies, Machine]:
    """Put three obstacles around the machine."""
    config = vary(bodies_config, {"task.obstacles": OBSTACLES})
    pairs = build_obstacles(config.machine, config.task.obstacles)
    assert pairs is not None
    return pairs, build_machine(config.machine)


def test_intervals_are_what_many_x_show(scene: tuple[Bodies, Machine], draw_poses) -> None:
    """No collision outside of them, and none free inside, at 50 x of 40 poses."""
    pairs, machine = scene
    drawn = draw_poses(machine, 3, 40)
    pose, q = drawn.pose.copy(), drawn.q_m.copy()
    q[:, :3] -= pose[:, :1]
    pose[:, 0] = 0.0
    n = len(pose)
    excluded = excluded_shifts(pairs, PoseSamples(machine, pose, q), np.tile(WINDOW, (n, 1)))
    hits = 0
    for x in np.linspace(*WINDOW, 50):
        moved, carts = pose.copy(), q.copy()
        moved[:, 0] += x
        carts[:, :3] += x
        distances = body_distances(pairs, PoseSamples(machine, moved, carts), 0.02)
        inside = (x > excluded[..., 0]) & (x < excluded[..., 1])
        assert not ((distances < pairs.clearance_m) & ~inside).any()
        assert not ((distances > pairs.clearance_m + 1e-5) & inside).any()
        hits += np.count_nonzero(inside)
    assert hits > 100


def test_ends_of_intervals_are_allowed(scene: tuple[Bodies, Machine], draw_poses) -> None:
    """There the distance is the clearance, to a micrometre."""
    pairs, machine = scene
    drawn = draw_poses(machine, 5, 40)
    samples = PoseSamples(machine, drawn.pose, drawn.q_m)
    windows = np.tile([-3.0, 3.0], (len(drawn.pose), 1))
    excluded = excluded_shifts(pairs, samples, windows)
    rows, columns = np.nonzero(np.isfinite(excluded[..., 0]))
    assert len(rows) > 20
    for side in (0, 1):
        shift = excluded[rows, columns, side]
        pose, q = samples.pose[rows].copy(), samples.q_m[rows].copy()
        pose[:, 0] += shift
        q[:, :3] += shift[:, None]
        distances = body_distances(pairs, PoseSamples(machine, pose, q))[np.arange(len(rows)), columns]
        assert (distances >= pairs.clearance_m).all()
        assert (distances <= pairs.clearance_m + 2e-6).all()


@given(
    intervals=st.lists(st.tuples(st.integers(-2, 12), st.integers(1, 6)), max_size=5),
    window=st.tuples(st.integers(0, 9), st.integers(0, 10)),
)
def test_pieces_are_what_is_left(intervals: list[tuple[int, int]], window: tuple[int, int]) -> None:
    """Every x of the window is in a piece exactly if it is in no interval; pieces are told apart."""
    low, high = float(window[0]), float(window[0] + window[1])
    excluded = np.full((1, 6, 2), np.nan)
    for k, (begin, length) in enumerate(intervals):
        excluded[0, k] = begin, begin + length
    row, found = free_pieces(np.array([[low, high]]), excluded)
    assert not row.any()
    for x in np.arange(low, high + 0.25, 0.5):
        free = not any(begin < x < begin + length for begin, length in intervals)
        assert free == any(first <= x <= last for first, last in found.tolist())
    assert len({tuple(one) for one in found.tolist()}) == len(found)
    (longest,) = longest_free(np.array([[low, high]]), excluded)
    lengths = found[:, 1] - found[:, 0]
    assert np.isnan(longest).all() if len(found) == 0 else longest[1] - longest[0] == lengths.max()
