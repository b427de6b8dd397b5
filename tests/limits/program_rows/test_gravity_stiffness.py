"""Gravity stiffness in the nonlinear program: pivots instead of eigenvalues, at nodes that come near the limit."""

from collections.abc import Callable
from dataclasses import replace

import casadi as ca
import numpy as np
from hypothesis import example, given, settings
from hypothesis import strategies as st

from pipeline.limits.gravity_stiffness import stiffness_limit
from pipeline.limits.interface.rows import Nodes, ProgramPart
from pipeline.machine import Machine
from pipeline.machine.samples import PoseSamples


def _part(samples: PoseSamples, least_npm: float) -> tuple[ProgramPart, ca.MX, ca.MX]:
    limit = stiffness_limit(replace(samples.machine, gravity_stiffness_npm=least_npm))
    assert limit is not None
    n = len(samples)
    pose, q = ca.MX.sym("pose", 6, n), ca.MX.sym("q", 5, n)
    nodes = Nodes(pose, q, samples, np.zeros((n, 5)), clearance_margin_m=0.0, reach_m=0.05)
    return limit.program_part(nodes), pose, q


@given(seed=st.integers(0, 2**32 - 1))
@settings(max_examples=10)
@example(seed=2804)
def test_rows_hold_exactly_where_the_values_do(machine: Machine, draw_poses: Callable, seed: int):
    """At the guess, and a little off it, where the directions of the guess are not those of the eigenvectors."""
    drawn = draw_poses(machine, seed, 60, 40.0)
    samples = PoseSamples(machine, drawn.pose, drawn.q_m).take(slice(0, 12))
    # So small a limit is near everywhere.
    least = max(float(np.median(samples.gravity_stiffness_npm)) - 1.0, -800.0)
    part, pose, q = _part(samples, least)
    if len(samples) < 3:
        assert part.rows == ()
        return
    (row,) = part.rows
    limit = stiffness_limit(replace(machine, gravity_stiffness_npm=least))
    assert limit is not None
    ends = limit.values(samples)[[0, -1]].min()
    margin = float(np.clip(ends, 0.0, limit.node_margin(0.0)))
    evaluate = ca.Function("row", [pose, q], [row.expression])
    for off in (0.0, 1e-3):
        beside = PoseSamples(machine, samples.pose + off, samples.q_m)
        found = np.array(evaluate(beside.pose.T, beside.q_m.T)).reshape(-1, 5)
        room = limit.values(beside)[1:-1, 0] - margin
        # Beside the guess the links do not close, and the two differ by as much.
        clear = np.abs(room) > 1e-9 + 10.0 * off
        np.testing.assert_array_equal((found >= row.low - 1e-9).all(axis=1)[clear], (room >= 0.0)[clear])


@given(seed=st.integers(0, 2**32 - 1))
@settings(max_examples=3)
def test_nodes_far_from_the_limit_have_no_rows(machine: Machine, draw_poses: Callable, seed: int):
    """A machine whose drives bear a lot is planned as without the limit."""
    drawn = draw_poses(machine, seed, 60, 40.0)
    samples = PoseSamples(machine, drawn.pose, drawn.q_m)
    part, _, _ = _part(samples, 20.0 * float(samples.gravity_stiffness_npm.min()) - 1_000.0)
    assert part.rows == ()
    assert part.unknowns == ()
