"""Separating planes of bodies in the nonlinear program."""

import casadi as ca
import numpy as np
import pytest

from pipeline.limits.interface.rows import Nodes, ProgramPart
from pipeline.limits.program_rows.bodies import separation_part
from pipeline.machine import Machine
from pipeline.machine.bodies.distances import body_distances
from pipeline.machine.kinematics import inverse_kinematics
from pipeline.machine.samples import PoseSamples

REACH_M, MARGIN_M = 0.02, 0.002


@pytest.fixture(scope="module")
def samples(bodies_machine: Machine) -> PoseSamples:
    """Give eight poses in one working mode, at some of which bodies come near."""
    s = np.linspace(0.0, 1.0, 8)
    controlled = np.column_stack([1.1 + 0.0 * s, 0.3 + 0.2 * s, 0.9 - 0.2 * np.sin(np.pi * s), -0.2 * s, -0.1 * s])
    solution = inverse_kinematics(bodies_machine, controlled, np.zeros(8, dtype=int))
    assert np.isfinite(solution.q_m).all()
    return PoseSamples(bodies_machine, solution.pose, solution.q_m)


def part_of(samples: PoseSamples) -> tuple[ProgramPart, Nodes]:
    """Write the rows for poses and actuators as symbols."""
    bodies, k = samples.machine.bodies, len(samples)
    assert bodies is not None
    pose, q = ca.MX.sym("pose", 6, k), ca.MX.sym("q", 5, k)
    nodes = Nodes(pose, q, samples, np.zeros((k, 5)), MARGIN_M, REACH_M)
    return separation_part("bodies", bodies, body_distances(samples.machine.bodies, samples), nodes), nodes


def test_rows_at_the_guess_hold_the_distances(samples: PoseSamples) -> None:
    """The least entry is half of what the least distance lacks: planes are in the middle, normals unit vectors."""
    part, nodes = part_of(samples)
    normal, offset = part.unknowns
    rows = ca.Function(
        "rows", [nodes.pose, nodes.q, normal.symbol, offset.symbol], [row.expression for row in part.rows]
    )
    apart, length = rows(samples.pose.T, samples.q_m.T, normal.guess.T, offset.guess.T)
    bodies = samples.machine.bodies
    assert bodies is not None
    distances = body_distances(samples.machine.bodies, samples)[1:-1]
    near = distances[distances < bodies.clearance_m + REACH_M]
    assert 0 < len(near) == len(normal.guess)
    assert float(ca.mmin(apart)) == pytest.approx((near.min() - bodies.clearance_m - MARGIN_M) / 2.0, abs=1e-9)
    np.testing.assert_allclose(np.array(length), 1.0)


def test_what_is_endless_along_x_has_no_x_in_its_normal(samples: PoseSamples) -> None:
    """Its bounds fix it."""
    part, _ = part_of(samples)
    normal = part.unknowns[0]
    assert np.isinf(normal.high).any()
    fixed = normal.high[:, 0] == 0.0
    assert not normal.guess[fixed, 0].any()


def test_nothing_near_needs_no_rows(samples: PoseSamples) -> None:
    """Nor unknowns."""
    machine, k = samples.machine, len(samples)
    assert machine.bodies is not None
    nodes = Nodes(ca.MX.sym("pose", 6, k), ca.MX.sym("q", 5, k), samples, np.zeros((k, 5)), 0.0, REACH_M)
    far = np.ones((k, len(machine.bodies.pairs)))
    part = separation_part("bodies", machine.bodies, far, nodes)
    assert (part.unknowns, part.rows) == ((), ())
