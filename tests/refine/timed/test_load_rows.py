"""Rows of forces in motion and of the TCP's motion, on straight moves along X."""

from dataclasses import replace

import casadi as ca
import numpy as np
import pytest

from pipeline.machine import Machine
from pipeline.refine import Path
from pipeline.refine.collocation.program import Symbols
from pipeline.refine.timed.load_rows import Motion, load_part
from pipeline.refine.timed.loads import load_shares

COUNT = 20


def _unknown(path: Path) -> Motion:
    nodes = len(path.node_s)
    x = Symbols(ca.MX.sym("pose", 6, nodes), ca.MX.sym("q", 5, nodes), ca.MX.sym("c", 5, COUNT))
    return Motion(x, ca.MX.sym("time"), path)


@pytest.fixture(scope="module")
def motion(straight_motion) -> Path:
    """Drive along X with friction, fast enough to come near a limit of the carts' forces."""
    path = straight_motion(COUNT)
    masses = replace(path.machine.masses, friction_n=np.full(5, 15.0))
    weak = path.machine.force_n / 4.0
    limits = replace(path.machine, masses=masses, force_n=weak, tcp_speed_mps=0.5, tcp_acceleration_mps2=2.0)
    return replace(path, machine=limits)


def test_rows_are_the_loads_of_the_guess(motion: Path) -> None:
    """At the guess its velocities and accelerations solve the equations, and the largest row is the largest share."""
    unknown = _unknown(motion)
    part, x = load_part(unknown, motion.node_s), unknown.x
    names = {row.name for row in part.rows}
    assert {
        "velocity of the platform",
        "equilibrium in motion",
        "TCP speed",
        "TCP acceleration",
        "force of c1",
    } <= names
    known = [x.pose, x.q, x.coefficients, unknown.time, *(own.symbol for own in part.unknowns)]
    guess = [motion.node_pose.T, motion.q(motion.node_s).T, motion.spline.c.T, 1.0]
    guess += [own.guess.T for own in part.unknowns]
    for row in part.rows[:2]:
        assert np.abs(np.array(ca.Function("row", known, [row.expression])(*guess))).max() < 1e-8
    shares = load_shares(motion, motion.node_s, float(motion.motion_s or 0.0))[1:-1, -2:].max(axis=0)
    for name, share in zip(("TCP speed", "TCP acceleration"), shares, strict=True):
        row = next(row for row in part.rows if row.name == name)
        values = np.array(ca.Function("row", known, [row.expression])(*guess))
        assert np.sqrt(values.max()) == pytest.approx(share, rel=1e-6)


def test_nothing_is_added_far_from_all_limits(machine: Machine, straight_motion) -> None:
    """The motion is slow, or there are no limits."""
    slow = replace(straight_motion(COUNT), motion_s=20.0)
    for path in (slow, replace(slow, machine=replace(machine, masses=None), motion_s=1.0)):
        assert load_part(_unknown(path), path.node_s).rows == ()
