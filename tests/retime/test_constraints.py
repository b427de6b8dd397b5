"""Limits as rows: against the quantities they stand for, and the maximum-velocity curve by brute force."""

from dataclasses import replace

import numpy as np
import pytest

from pipeline.refine.result import Path
from pipeline.retime.constraints import largest_speed, limit_rows
from pipeline.retime.path_dynamics import evaluate_dynamics
from pipeline.retime.quantities import evaluate, fractions, limits


@pytest.fixture(scope="module")
def tight(path: Path) -> Path:
    """The curve, with a limit of every kind."""
    return replace(path, machine=replace(path.machine, tcp_speed_mps=0.4, tcp_acceleration_mps2=1.0))


def test_rows_say_what_the_quantities_say(tight: Path) -> None:
    """The largest row is the largest fraction of all limits of second order; polygons are within 0.13 % of circles.

    The outer polygon is around the circle: its rows are below the fraction.
    """
    generator = np.random.default_rng(1)
    dynamics = evaluate_dynamics(tight, generator.uniform(0.0, 1.0, 300))
    v, w = generator.uniform(0.0, 0.5, 300), generator.uniform(-2.0, 2.0, 300)
    rows = limit_rows(dynamics)
    values, allowed = evaluate(dynamics, v, w, 0.0 * v), limits(tight.machine)
    for kind in ("acceleration", "force", "link_force", "tcp_acceleration"):
        those = [k for k, (name, _) in enumerate(rows.labels) if name == kind]
        largest = (rows.a * w[:, None] + rows.b * v[:, None] ** 2 + rows.c)[:, those].max(axis=1)
        expected = fractions(values[kind], allowed[kind]).max(axis=1)
        assert np.all(largest >= expected * (1.0 - 1e-9))
        assert np.all(largest <= expected * (1.0013 if kind == "tcp_acceleration" else 1.0 + 1e-9))
    outer = limit_rows(dynamics, outer=True)
    largest = (outer.a * w[:, None] + outer.b * v[:, None] ** 2 + outer.c)[:, those].max(axis=1)
    assert np.all(largest <= expected * (1.0 + 1e-9))
    assert np.all(largest >= expected / 1.0013)
    with np.errstate(divide="ignore"):
        speeds = np.maximum(
            (np.abs(values["velocity"]) / allowed["velocity"]).max(axis=1), values["tcp_speed"][:, 0] / 0.4
        )
    assert v / rows.cap == pytest.approx(speeds)


def test_the_maximum_velocity_curve_is_where_no_acceleration_is_left(tight: Path) -> None:
    """By brute force: at 99.9 % some path acceleration keeps all rows, at 100.1 % none does, or a speed is too high."""
    rows = limit_rows(evaluate_dynamics(tight, np.linspace(0.02, 0.98, 40)))
    top = largest_speed(rows)

    def room(speed: np.ndarray) -> np.ndarray:
        rest = 1.0 - rows.c - rows.b * speed[:, None] ** 2
        with np.errstate(divide="ignore", invalid="ignore"):
            high = np.where(rows.a > 0.0, rest / rows.a, np.inf).min(axis=1)
            low = np.where(rows.a < 0.0, rest / rows.a, -np.inf).max(axis=1)
        return high - low

    assert np.all(room(0.999 * top) > 0.0)
    assert np.all((room(1.001 * top) < 0.0) | (1.001 * top > rows.cap))
    assert np.all(top <= rows.cap)
