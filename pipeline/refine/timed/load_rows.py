"""Forces in motion and the motion of the TCP in the program: velocities, accelerations and links' forces as unknowns.

Only where the motion that the program starts from comes near such a limit, nodes get rows. There

    d/dt closure = 0,  d^2/dt^2 closure = 0,  H f = w,

with the actuators' rates those of the splines, tie the unknowns to the motion (`machine.symbolic`); all rows are
products of smooth functions.
"""

from dataclasses import dataclass

import casadi as ca
import numpy as np
from scipy.interpolate import BSpline
from scipy.sparse import csr_array

from pipeline.arrays import BoolArray, FloatArray, IntArray
from pipeline.limits.interface.rows import ProgramPart, Row, Unknowns
from pipeline.machine.geometry import ACTUATORS, LINKS
from pipeline.machine.samples import PoseSamples
from pipeline.machine.symbolic import dynamics_function, rates_function
from pipeline.refine.collocation.program import Symbols
from pipeline.refine.collocation.rows import sparse
from pipeline.refine.motion import pose_derivatives
from pipeline.refine.result import Path, directions_of
from pipeline.refine.timed.loads import limits_loads, load_shares

_NEAR_FORCE, _NEAR_TCP = 0.8, 0.5
"""Share of a force limit from which on a node gets rows, and of a limit of the TCP from which on all do: forces are
mostly gravity, while a motion that saves time is as fast as it may be everywhere."""
_FORCES = len(ACTUATORS) + len(LINKS)
_AT_NODES = 0.998
"""Share of the limits that nodes keep: between two of them loads may be a little larger."""


@dataclass(frozen=True, eq=False)
class Motion:
    """A motion as unknowns, and its guess.

    Attributes
    ----------
    x : Symbols
        Nodes and coefficients.
    time : (1, 1)
        T relative to its guess.
    guess : Path
        The motion that the program starts from, with its duration.
    """

    x: Symbols
    time: ca.MX
    guess: Path

    @property
    def guess_s(self) -> float:
        """T of the guess, seconds."""
        return float(self.guess.motion_s or np.nan)


def load_part(motion: Motion, tau: FloatArray) -> ProgramPart:
    """Write the rows of the nodes tau (k,) near a limit of loads."""
    none = ProgramPart(unknowns=(), rows=())
    if not limits_loads(motion.guess.machine):
        return none
    shares = load_shares(motion.guess, tau, motion.guess_s)
    forces = shares[:, :_FORCES].max(axis=1) > _NEAR_FORCE
    near = forces | (shares[:, _FORCES:].max() > _NEAR_TCP)
    # Start and goal are at rest.
    near[[0, -1]] = False
    return _part_at(motion, tau, (np.flatnonzero(near), forces[near])) if near.any() else none


def _part_at(motion: Motion, tau: FloatArray, nodes: tuple[IntArray, BoolArray]) -> ProgramPart:
    """Write the rows of some nodes (m,), and which of them are near a limit of forces (m,)."""
    near, with_forces = nodes
    path, x, motion_s = motion.guess, motion.x, motion.guess_s
    machine, at, m = path.machine, near.tolist(), len(near)
    pose, first, second, _ = pose_derivatives(path, tau[near])
    rate, acceleration = ca.MX.sym("pose_rate", 6, m), ca.MX.sym("pose_acceleration", 6, m)
    q_rate, q_acceleration = (
        x.coefficients @ _derivatives(path.spline, tau[near], order).T / (motion_s * motion.time) ** order
        for order in (1, 2)
    )
    z = ca.vertcat(x.pose[:, at], x.q[:, at]), ca.vertcat(rate, q_rate), ca.vertcat(acceleration, q_acceleration)
    unknowns = [_free(rate, first / motion_s), _free(acceleration, second / motion_s**2)]
    rows = [
        Row(f"{name} of the platform", ca.vec(missed), 0.0, 0.0)
        for name, missed in zip(("velocity", "acceleration"), rates_function(machine).map(m)(*z), strict=True)
    ]
    tcp = ("TCP speed", rate, machine.tcp_speed_mps), ("TCP acceleration", acceleration, machine.tcp_acceleration_mps2)
    for name, moves, limit in tcp:
        if np.isfinite(limit):
            rows.append(Row(name, ca.sum1(moves[:3, :] ** 2).T / limit**2, -np.inf, _AT_NODES**2))
    if with_forces.any():
        samples = PoseSamples(machine, pose[with_forces], path.q(tau[near[with_forces]]))
        scale = max(float(np.abs(samples.holding_forces_n).max()), 1.0)
        f = ca.MX.sym("link_forces", len(LINKS), len(samples))
        unknowns.append(_free(f, samples.holding_forces_n[:, len(ACTUATORS) :] / scale))
        columns = np.flatnonzero(with_forces).tolist()
        taken = [part[:, columns] for part in z]
        missed, drives = dynamics_function(machine).map(len(samples))(*taken, scale * f)
        rows.append(Row("equilibrium in motion", ca.vec(missed) / scale, 0.0, 0.0))
        rows += _force_rows(path, tau, near[with_forces], (drives, scale * f))
    return ProgramPart(tuple(unknowns), tuple(rows))


def _force_rows(path: Path, tau: FloatArray, near: IntArray, forces: tuple[ca.MX, ca.MX]) -> list[Row]:
    """Bound the forces of drives (5, m), with friction, and along links (6, m), in units of their limits."""
    machine, (drives, links) = path.machine, forces
    masses, (push, pull) = machine.masses, machine.force_limits_n
    assert masses is not None, "forces are bounded for machines with masses only"
    signs = directions_of(path.q(tau, 1))
    # Directions change between nodes: those of the neighbours count, too.
    beside = np.stack([signs[near + shift] for shift in (-1, 0, 1)])
    rows = []
    for drive in np.flatnonzero(np.isfinite(push[: len(ACTUATORS)])).tolist():
        for sign in (-1.0, 0.0, 1.0):
            taken = np.flatnonzero((beside[:, :, drive] == sign).any(axis=0)).tolist()
            if taken:
                force = drives[drive, taken].T + sign * float(masses.friction_n[drive])
                rows += _between(f"force of {ACTUATORS[drive]}", force, (float(pull[drive]), float(push[drive])))
    for link in np.flatnonzero(np.isfinite(push[len(ACTUATORS) :])).tolist():
        limits = float(pull[len(ACTUATORS) + link]), float(push[len(ACTUATORS) + link])
        rows += _between(f"force of link {LINKS[link]}", links[link, :].T, limits)
    return rows


def _between(name: str, force: ca.MX, limits: tuple[float, float]) -> list[Row]:
    """Bound a force (m, 1) by the limits of pull and push."""
    (pull, push) = limits
    middle, half = (push - pull) / 2.0, (push + pull) / 2.0
    return [Row(name, (force - middle) / half, -_AT_NODES, _AT_NODES)]


def _free(symbol: ca.MX, guess: FloatArray) -> Unknowns:
    free = np.full_like(guess, np.inf)
    return Unknowns(symbol, guess, -free, free)


def _derivatives(spline: BSpline, tau: FloatArray, order: int) -> ca.DM:
    """Write a derivative of all basis functions at tau (m,). Shape (m, n)."""
    count = len(spline.t) - spline.k - 1
    return sparse(csr_array(BSpline(spline.t, np.eye(count), spline.k)(tau, nu=order)))
