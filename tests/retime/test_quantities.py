"""The quantities of a motion: against differences of real motions, their limits, and what forces leave for motion."""

from dataclasses import replace

import numpy as np
import pytest

from pipeline.machine import Machine
from pipeline.machine.dynamics import inverse_dynamics
from pipeline.machine.geometry import ACTUATORS
from pipeline.refine.result import Path
from pipeline.retime import TrajectoryFigures, measure_usage
from pipeline.retime.constraints import limit_rows
from pipeline.retime.fastest import plan, plan_rows
from pipeline.retime.path_dynamics import PathDynamics, evaluate_dynamics, grid
from pipeline.retime.quantities import (
    QUANTITIES,
    Quantity,
    at_rest,
    evaluate,
    fractions,
    limited,
    limits,
    moving_shares,
)
from pipeline.summary.trajectory import trajectory_section


@pytest.fixture(scope="module")
def tight(path: Path) -> Path:
    """The curve, with a limit of every kind."""
    return replace(path, machine=replace(path.machine, tcp_speed_mps=0.4, tcp_acceleration_mps2=1.0))


@pytest.fixture(scope="module")
def dynamics(path: Path) -> PathDynamics:
    """The curve with friction, at places all along it."""
    masses = replace(path.machine.masses, friction_n=np.full(5, 20.0))
    return evaluate_dynamics(replace(path, machine=replace(path.machine, masses=masses)), np.linspace(0.02, 0.98, 60))


def test_quantities_are_those_of_the_motion(tight: Path) -> None:
    """For s(t) = s0 + v t + w t^2 / 2 + j t^3 / 6, by central differences of q, pose and forces at t = 0."""
    s0, v, w, j, h = 0.4, 0.3, -0.8, 5.0, 1e-3
    t = h * np.arange(-2, 3)
    s = s0 + v * t + w * t**2 / 2.0 + j * t**3 / 6.0
    q, pose = tight.q(s), tight.pose(s)
    found = evaluate(evaluate_dynamics(tight, np.array([s0])), *(np.array([x]) for x in (v, w, j)))
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


def test_limits_are_optional(machine: Machine) -> None:
    """What has no limit is infinite and not limited; forces are limited only with masses."""
    assert limited(machine) == ("velocity", "acceleration", "jerk", "force", "link_force")
    assert limited(replace(machine, masses=None)) == ("velocity", "acceleration", "jerk")
    bare = replace(machine, jerk_mps3=np.full(5, np.inf), force_n=np.full(5, np.inf), link_force_n=np.inf)
    assert limited(bare) == ("velocity", "acceleration")
    assert [limits(machine)[row.name].shape[-1] for row in QUANTITIES] == [len(row.subjects) for row in QUANTITIES]
    assert [row.words for row in QUANTITIES][4:] == ["link force", "TCP speed", "TCP acceleration"]


@pytest.mark.parametrize("w", [-1.5, 0.7])
def test_a_share_of_one_is_the_limit(dynamics: PathDynamics, w: float) -> None:
    """A force is above its limit where the share is above one, and nowhere else."""
    v, w_all = np.full(60, 0.3), np.full(60, w)
    values = evaluate(dynamics, v, w_all, 0.0 * v)
    force = np.array([[120.0, 120.0, 120.0, 450.0, 450.0], [90.0, 130.0, 140.0, 300.0, 500.0]])
    weak = replace(dynamics, machine=replace(dynamics.machine, force_n=force, link_force_n=np.array([450.0, 350.0])))
    allowed = limits(weak.machine)
    for name, share in moving_shares(weak, values).items():
        held = fractions(at_rest(dynamics)[name], allowed[name]) < 1.0
        assert np.array_equal((share > 1.0)[held], (fractions(values[name], allowed[name]) > 1.0)[held])


def test_time_stretched_by_two_takes_a_quarter(dynamics: PathDynamics) -> None:
    """Motion's part of a force falls with the square of the time it has."""
    v, w = np.full(60, 0.3), np.full(60, 0.7)
    one = moving_shares(dynamics, evaluate(dynamics, v, w, 0.0 * v))
    other = moving_shares(dynamics, evaluate(dynamics, v / 2.0, w / 4.0, 0.0 * v))
    for name, share in one.items():
        assert other[name] == pytest.approx(share / 4.0)


def test_without_room_or_without_a_limit(dynamics: PathDynamics) -> None:
    """Where rest uses up the limit, the share of any motion is infinite; without a limit it is zero."""
    v, w = np.full(60, 0.3), np.full(60, 0.7)
    values = evaluate(dynamics, v, w, 0.0 * v)
    force = np.array([1e-6, np.inf, np.inf, np.inf, np.inf])
    share = moving_shares(replace(dynamics, machine=replace(dynamics.machine, force_n=force)), values)["force"]
    assert np.isinf(share[:, 0]).any()
    assert not share[:, 1:].any()


POWER = Quantity(
    "drive_power",
    "W",
    ACTUATORS,
    limit=lambda machine: np.array([200.0, 200.0, 200.0, np.inf, np.inf]),
    value=lambda path, t: (path.a[:, :5] * t.sdd + path.b[:, :5] * t.sd**2 + path.c[:, :5]) * path.q1 * t.sd,
    known=lambda machine: machine.masses is not None,
)
"""A quantity that the pipeline does not have: forces times velocities of the drives."""


def test_a_row_is_all_a_new_quantity_takes(path: Path) -> None:
    """One more row is measured, and is in usage, peaks and the summary; without masses it is skipped."""
    trajectory, quantities = plan(path, 500), (*QUANTITIES, POWER)
    usage = measure_usage(trajectory, 0.01, quantities=quantities)
    t = np.linspace(0.0, trajectory.duration_s, 5_001)
    s, *state = (trajectory.s(t, order) for order in range(4))
    values = evaluate(evaluate_dynamics(path, s), *state)
    power = np.abs(values["force"] * values["velocity"]).max(axis=0)
    assert usage.peaks["drive_power"] == pytest.approx(power, rel=5e-3)
    assert usage.fractions["drive_power"] == pytest.approx([*power[:3] / 200.0, 0.0, 0.0], rel=5e-3)
    section = trajectory_section(TrajectoryFigures(1.0, 0.01, 101, usage))
    assert list(section["usage"]) == list(section["peak"]) == [row.name for row in quantities]
    assert np.array_equal(section["usage"]["drive_power"], usage.fractions["drive_power"])
    massless = replace(path, machine=replace(path.machine, masses=None))
    skipped = measure_usage(replace(trajectory, path=massless), quantities=quantities)
    assert trajectory_section(TrajectoryFigures(1.0, 0.01, 101, skipped))["usage"]["drive_power"] == "skipped"


def test_a_row_with_coefficients_is_planned_with(path: Path) -> None:
    """One more quantity of second order becomes rows of the planner, which then keeps its limit."""
    belt = Quantity(
        "belt_force",
        "N",
        ACTUATORS,
        limit=lambda machine: np.array([170.0, np.inf, np.inf, np.inf, np.inf]),
        value=lambda path, t: path.a[:, :5] * t.sdd + path.b[:, :5] * t.sd**2 + path.c[:, :5],
        known=lambda machine: machine.masses is not None,
        linear=lambda path: (path.a[:, :5], path.b[:, :5], path.c[:, :5]),
    )
    quantities, s = (*QUANTITIES, belt), grid(2_000)
    free, kept = (
        plan_rows(path, s, limit_rows(evaluate_dynamics(path, s), quantities=rows)) for rows in (QUANTITIES, quantities)
    )
    usage = [measure_usage(one, quantities=quantities).fractions["belt_force"][0] for one in (free, kept)]
    assert usage[0] > 1.05
    assert usage[1] == pytest.approx(1.0, abs=2e-3)
    assert kept.duration_s > free.duration_s
