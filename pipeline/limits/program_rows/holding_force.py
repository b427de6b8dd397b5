"""Holding forces in the nonlinear program: the links' forces as unknowns, tied to the pose by equilibrium.

With the forces as unknowns all rows are products of smooth functions; solved for the forces they would be quotients by
det H.
"""

from typing import TYPE_CHECKING

import casadi as ca
import numpy as np

from pipeline.limits.interface.direction import counting
from pipeline.limits.interface.rows import Nodes, ProgramPart, Row, Unknowns
from pipeline.machine.geometry import LINKS
from pipeline.machine.symbolic import holding_function

if TYPE_CHECKING:
    from pipeline.limits.holding_force import HoldingForce

_NEAR = 0.25
"""Nodes at which a force comes within this part of its limit get rows."""


def holding_part(limit: "HoldingForce", margin: float, nodes: Nodes) -> ProgramPart:
    """Write H f = w and the bounds of all forces at the inner nodes that come near a limit, less a margin.

    The directions of motion are those at the initial guess.
    """
    applies = counting(limit, nodes.guess, nodes.directions)
    near = np.asarray(((limit.values(nodes.guess) < _NEAR) & applies).any(axis=1), dtype=bool)
    # Start and goal are given.
    rows = np.flatnonzero(near[1:-1]) + 1
    if len(rows) == 0:
        return ProgramPart(unknowns=(), rows=())
    guess, k = nodes.guess.take(rows), len(rows)
    scale = max(float(np.abs(guess.holding_forces_n).max()), 1.0)
    part = ca.MX.sym("f", len(LINKS), k)
    at = rows.tolist()
    residual, drives = holding_function(guess.machine).map(k)(nodes.pose[:, at], nodes.q[:, at], scale * part)
    forces = ca.vertcat(drives / scale, part)
    free = np.full((k, len(LINKS)), np.inf)
    found = [Row(f"{limit.wording.name} (equilibrium)", ca.vec(residual / scale), 0.0, 0.0)]
    # What is within the margin at the start or the goal, which are given, keeps what it has there.
    margins = np.clip(limit.values(nodes.guess.take(np.array([0, -1]))).min(axis=0), 0.0, margin)
    allowed = np.maximum(limit.allowed_n - margins * limit.column_limits_n, 0.0) / scale
    columns = zip(limit.column_subjects.tolist(), limit.column_signs.tolist(), allowed.tolist(), strict=True)
    for column, (subject, sign, most) in enumerate(columns):
        counts = np.flatnonzero(applies[rows, column]).tolist()
        if counts:
            found.append(Row(limit.wording.name, sign * forces[subject, counts].T, -np.inf, most))
    return ProgramPart((Unknowns(part, guess.holding_forces_n[:, 5:] / scale, -free, free),), tuple(found))
