"""The real types of results, filled with a short path of the reference machine."""

from dataclasses import replace

import numpy as np
from scipy.interpolate import PPoly, make_interp_spline

from pipeline.certify import Certificate, ProvenChain, Tolerance, path_sha256
from pipeline.certify.guess import point_box
from pipeline.inclusion.krawczyk import Box
from pipeline.inclusion.uncertainty import CERTAIN, of_actuators, of_everything, of_lengths
from pipeline.machine import Machine, inverse_kinematics
from pipeline.refine.result import Path, Refinement
from pipeline.retime.result import Trajectory
from pipeline.route.regions.build import RegionTable
from pipeline.route.result import Route, Search
from pipeline.status import Status
from tests.certify.paths import bounds_of

NODES = 21


def line_of_poses(machine: Machine, count: int) -> tuple[np.ndarray, np.ndarray]:
    """Poses (n, 6) and actuators (n, 5) on a short line in working mode LLL."""
    controlled = np.linspace([1.02, 0.3, 0.9, 0.0, 0.0], [1.05, 0.33, 0.88, 0.05, -0.02], count)
    solution = inverse_kinematics(machine, controlled, np.zeros(count, dtype=int))
    return solution.pose, solution.q_m


def make_regions(machine: Machine, count: int = 5) -> RegionTable:
    """Make a table of a few regions with a column of each kind of value."""
    pose, q = line_of_poses(machine, count)
    return RegionTable(
        controlled=pose[:, [0, 1, 2, 3, 5]],
        ry_rad=pose[:, 4],
        modes=np.arange(count) % 8,
        gates=np.arange(count) % 4,
        q_m=q,
        kappa=np.geomspace(20.0, 30.0, count),
        det_sign=np.ones(count),
        link_distance_m=np.linspace(0.03, 0.1, count),
        x_window_m=np.stack([np.linspace(0.1, 0.2, count), np.linspace(1.0, 1.1, count)], axis=1),
        visits=np.arange(count) % 2,
    )


def make_route(machine: Machine, objective: float = 100.0, status: Status = Status.OPTIMAL) -> Route:
    """Make a route of four steps with one change of working mode; the bound is 100 where it is not proven optimal."""
    bound = objective if status is Status.OPTIMAL else 100.0
    pose, q = line_of_poses(machine, 4)
    return Route(
        region=np.array([3, 0, 1, 4]),
        modes=np.array([0, 0, 0, 1]),
        gates=np.array([0, 0, 3, 0]),
        visits=np.array([0, 1, 0, 0]),
        pose=pose,
        q_m=q,
        kappa=np.array([25.0, 1.0 / 0.03, 30.0, 24.0]),
        objective=objective,
        status=status,
        search=Search("HiGHS 1", bound, 1.0 - bound / objective, 99.0, 105.0, 5, 40, 12, 2, 7, 3, 20.0),
    )


def make_path(machine: Machine, degree: int) -> Path:
    """Interpolate the line of poses in actuator space."""
    pose, q = line_of_poses(machine, NODES)
    s = np.linspace(0.0, 1.0, NODES)
    return Path(machine, make_interp_spline(s, q, k=degree), s, pose)


def make_refinement(machine: Machine) -> Refinement:
    """Make a refined path and a coarse one."""
    return Refinement(
        path=make_path(machine, 5),
        coarse=make_path(machine, 1),
        status=Status.CONVERGED,
        iterations=17,
        rounds=1,
        meshes=2,
        mesh_change=0.001,
        nodes=100,
        surrogate_integral=71.5,
    )


def make_certificate(path: Path) -> Certificate:
    """Make a certificate of one box, and of two more for machines that are a little wrong."""
    pose = path.pose(np.array([0.0, 0.5, 1.0]))
    box = Box(0.0, 1.0, np.vstack([pose[1], pose[2] - pose[0], np.zeros((2, 6))]), np.full(6, 0.1))
    joints = (point_box(0.0, pose[0]), point_box(1.0, pose[2]))
    proofs = [ProvenChain(given, (box,), joints) for given in (CERTAIN, of_lengths(1e-4), of_everything(1e-4))]
    return Certificate(
        path_sha256=path_sha256(path),
        premises_sha256="0" * 64,
        precision_bits=64,
        chain=proofs[0],
        bounds=bounds_of(),
        failure=None,
        link_length=Tolerance(1e-4, 1.1e-4, np.inf, proofs[1]),
        coordinates=Tolerance(1e-4, 1.1e-4, np.inf, proofs[2]),
    )


def with_tube(certificate: Certificate, error_m: float) -> Certificate:
    """Add a chain of actuators that are off alike, in place of that of coordinates."""
    errors = of_actuators(np.ones(5))(error_m)
    chain = replace(certificate.chain, uncertainty=errors)
    return replace(certificate, coordinates=Tolerance(1e-4, 1.1e-4, np.inf, chain))


def make_trajectory(path: Path) -> Trajectory:
    """Speed up for a second, slow down for a second: s = 10 u^3 - 15 u^4 + 6 u^5 with u = t / 2 s."""
    return Trajectory(path, PPoly(np.array([[6.0 / 32, -15.0 / 16, 10.0 / 8, 0.0, 0.0, 0.0]]).T, [0.0, 2.0]))
