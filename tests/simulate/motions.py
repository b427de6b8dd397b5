"""Motions for the twin, without the stages that plan them."""

from collections.abc import Callable
from dataclasses import fields, replace
from typing import Any

import numpy as np

from pipeline.machine import Machine, forward_kinematics
from pipeline.simulate import Motion
from pipeline.simulate.forces import forces_of


def make_motion(machine: Machine, curve: Any, poses: Callable[..., np.ndarray], period_s: float) -> Motion:
    """Sample a curve q(t), piecewise polynomials, with poses near poses(t) and forces by inverse dynamics."""
    t = np.arange(round(curve.x[-1] / period_s) + 1) * period_s
    fine = np.append(np.column_stack([t, t + period_s / 2.0]).ravel()[:-1], curve.x[-1]).clip(max=curve.x[-1])
    q, qd, qdd = (curve(fine, nu=order) for order in range(3))
    pose = forward_kinematics(machine, q, poses(fine))
    forces = forces_of(machine, pose, q, qd, qdd)
    at, middle = slice(0, None, 2), slice(1, None, 2)
    return Motion(
        period_s=period_s,
        t_s=t,
        q_m=q[at],
        qd_mps=qd[at],
        qdd_mps2=qdd[at],
        pose=pose[at],
        drive_n=forces.drive_n[at],
        link_n=forces.link_n[at],
        middle_n=forces.drive_n[middle],
        middle_mps=qd[middle],
        middle_mps2=qdd[middle],
    )


def part(motion: Motion, first: int, last: int, every: int = 1) -> Motion:
    """Take rows of a motion, with their times."""
    rows = {one.name: getattr(motion, one.name)[first:last:every] for one in fields(motion) if one.name != "period_s"}
    return replace(motion, **rows | {"t_s": motion.t_s[first:last:every] - motion.t_s[first]})


def backwards(motion: Motion) -> Motion:
    """Drive a motion back: the same forces without friction, and velocities of the other sign."""
    turned = {
        one.name: getattr(motion, one.name)[::-1] for one in fields(motion) if one.name not in ("period_s", "t_s")
    }
    turned["qd_mps"], turned["middle_mps"] = -turned["qd_mps"], -turned["middle_mps"]
    # The middles of periods lie before their rows now.
    for name in ("middle_n", "middle_mps", "middle_mps2"):
        turned[name] = np.vstack([turned[name][1:], turned[name][-1:]])
    return replace(motion, **turned)


def standing(machine: Machine, q_m: np.ndarray, pose: np.ndarray, seconds: float, period_s: float = 1e-3) -> Motion:
    """Stand still with actuators (5,) in a pose (6,)."""
    n = round(seconds / period_s) + 1
    q, poses, none = np.tile(q_m, (n, 1)), np.tile(pose, (n, 1)), np.zeros((n, 5))
    forces = forces_of(machine, poses, q, none, none)
    t = np.arange(n) * period_s
    return Motion(period_s, t, q, none, none, poses, forces.drive_n, forces.link_n, forces.drive_n, none, none)
