"""What limits are made of along a path: against differences of real motions, and rows against what they stand for."""

from dataclasses import replace

import numpy as np
import pytest

from pipeline.machine import Machine
from pipeline.machine.dynamics import inverse_dynamics
from pipeline.refine.result import Path
from pipeline.retime.constraints import largest_speed, limit_rows
from pipeline.retime.path_dynamics import grid, path_terms, terms_table
from pipeline.retime.quantities import KINDS, limited, limits


@pytest.fixture(scope="module")
def tight(path: Path) -> Path:
    """The curve, with a limit of every kind."""
    return replace(path, machine=replace(path.machine, tcp_speed_mps=0.4, tcp_acceleration_mps2=1.0))


def test_quantities_are_those_of_the_motion(tight: Path) -> None:
    """For s(t) = s0 + v t + w t^2 / 2 + j t^3 / 6, by central differences of q, pose and forces at t = 0."""
    s0, v, w, j, h = 0.4, 0.3, -0.8, 5.0, 1e-3
    t = h * np.arange(-2, 3)
    s = s0 + v * t + w * t**2 / 2.0 + j * t**3 / 6.0
    q, pose = tight.q(s), tight.pose(s)
    found = path_terms(tight, np.array([s0])).values(*(np.array([x]) for x in (v, w, j)))
    rate, second = (
        ((x[3] - x[1]) / (2.0 * h) for x in (q, pose)),
        ((x[3] - 2.0 * x[2] + x[1]) / h**2 for x in (q, pose)),
    )
    (qd, pd), (qdd, pdd) = rate, second
    third = (q[4] - 2.0 * q[3] + 2.0 * q[1] - q[0]) / (2.0 * h**3)
    assert found["velocity"][0] == pytest.approx(qd, abs=1e-4)
    assert found["acceleration"][0] == pytest.approx(qdd, abs=1e-3)
    assert found["jerk"][0] == pytest.approx(third, abs=0.05)
    assert found["tcp_speed"].item() == pytest.approx(np.linalg.norm(pd[:3]), abs=1e-4)
    assert found["tcp_acceleration"].item() == pytest.approx(np.linalg.norm(pdd[:3]), abs=1e-3)
    forces = inverse_dynamics(
        tight.machine, tight.machine.masses, pose[2:3], q[2:3, :3], pd[None], pdd[None], qdd[None, :3]
    )
    assert found["force"] == pytest.approx(forces.drive_n, abs=0.05)
    assert found["link_force"] == pytest.approx(forces.link_n, abs=0.05)


def test_a_table_gives_what_evaluating_gives(tight: Path) -> None:
    """Between the points of its grid, to seven digits of the largest."""
    s = np.sort(np.random.default_rng(0).uniform(0.0, 1.0, 200))
    table, exact = terms_table(tight, grid(2_001)).at(s), path_terms(tight, s)
    for name in ("q1", "q2", "q3", "tcp1", "tcp2", "a", "b", "c"):
        found, right = getattr(table, name), getattr(exact, name)
        assert np.abs(found - right).max() <= 1e-6 * np.abs(right).max()


def test_without_masses_and_tcp_limits_no_pose_is_needed(path: Path) -> None:
    """Then there are no forces and nothing of the TCP, and the path need not close."""
    bare = replace(path, machine=replace(path.machine, masses=None), node_pose=np.full_like(path.node_pose, np.nan))
    terms = terms_table(bare, grid(51)).at(np.array([0.3]))
    assert set(terms.values(*np.ones((3, 1)))) == {"velocity", "acceleration", "jerk"}


def test_friction_acts_against_the_motion_and_not_at_rest(path: Path) -> None:
    """Its force has the sign of q', and is no part of what a standing machine needs."""
    rubbing = replace(
        path, machine=replace(path.machine, masses=replace(path.machine.masses, friction_n=np.full(5, 20.0)))
    )
    s = np.linspace(0.05, 0.95, 7)
    with_it, without = path_terms(rubbing, s), path_terms(path, s)
    moving, still = np.full(7, 0.1), np.zeros(7)
    more = with_it.values(moving, still, still)["force"] - without.values(moving, still, still)["force"]
    assert more == pytest.approx(20.0 * np.sign(path.q(s, 1)))
    assert np.array_equal(with_it.values(still, still, still)["force"], without.values(still, still, still)["force"])


def test_an_actuator_that_stands_still_has_no_friction(line) -> None:
    """Carts move together along X: what rounding leaves of the telescopes' q' has signs, and no friction."""
    path = line(0.5)
    masses = replace(path.machine.masses, friction_n=np.array([20.0, 20.0, 20.0, 50.0, 50.0]))
    terms = path_terms(replace(path, machine=replace(path.machine, masses=masses)), np.linspace(0.0, 1.0, 400))
    assert np.abs(terms.q1[:, 3:]).max() > 0.0
    assert np.all(terms.friction() == [20.0, 20.0, 20.0, 0.0, 0.0])
    gravity = terms.c[:, :5]
    assert terms.resting()["force"][:, 3:] == pytest.approx(gravity[:, 3:], abs=0.0)


def test_rows_say_what_the_quantities_say(tight: Path) -> None:
    """The largest row is the largest fraction of all limits of second order; polygons are within 0.13 % of circles.

    The outer polygon is around the circle: its rows are below the fraction.
    """
    generator = np.random.default_rng(1)
    terms = path_terms(tight, generator.uniform(0.0, 1.0, 300))
    v, w = generator.uniform(0.0, 0.5, 300), generator.uniform(-2.0, 2.0, 300)
    rows = limit_rows(terms)
    values, allowed = terms.values(v, w, 0.0 * v), limits(tight.machine)
    for kind in ("acceleration", "force", "link_force", "tcp_acceleration"):
        those = [k for k, (name, _) in enumerate(rows.labels) if name == kind]
        largest = (rows.a * w[:, None] + rows.b * v[:, None] ** 2 + rows.c)[:, those].max(axis=1)
        expected = (np.abs(values[kind]) / allowed[kind]).max(axis=1)
        assert np.all(largest >= expected * (1.0 - 1e-9))
        assert np.all(largest <= expected * (1.0013 if kind == "tcp_acceleration" else 1.0 + 1e-9))
    outer = limit_rows(terms, outer=True)
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
    rows = limit_rows(path_terms(tight, np.linspace(0.02, 0.98, 40)))
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


def test_limits_are_optional(machine: Machine) -> None:
    """What has no limit is infinite, is not looked at, and has no rows; forces are looked at with masses only."""
    assert limited(machine) == ("velocity", "acceleration", "jerk", "force", "link_force")
    assert limited(replace(machine, masses=None)) == ("velocity", "acceleration", "jerk")
    bare = replace(machine, jerk_mps3=np.full(5, np.inf), force_n=np.full(5, np.inf), link_force_n=np.inf)
    assert limited(bare) == ("velocity", "acceleration")
    assert [len(limits(machine)[kind.name]) for kind in KINDS] == [len(kind.subjects) for kind in KINDS]
    assert [kind.words for kind in KINDS][4:] == ["link force", "TCP speed", "TCP acceleration"]
