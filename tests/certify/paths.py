"""Short paths whose certificates are known."""

import numpy as np
from scipy.interpolate import make_interp_spline

from pipeline.artifacts.certificate import chains
from pipeline.certify import Certificate
from pipeline.certify.recheck import StatedTolerance, Statement
from pipeline.machine import Machine, inverse_kinematics, statics_matrix
from pipeline.machine.geometry import MODES
from pipeline.machine.kinematics import follow
from pipeline.refine import Path
from pipeline.route.ends import End

START = np.array([1.02, 0.3, 0.9, 0.0, 0.0])
TOWARDS_SINGULARITY = np.array([0.0, -0.337, 0.122, -0.271, 0.243])
"""On this line of poses det H changes sign once, in working mode RLL."""
RLL = MODES.index("RLL")
NODES = 41


def pose_path(machine: Machine, controlled: np.ndarray, mode: int, nodes: int = NODES) -> Path:
    """Interpolate controlled poses (nodes, 5) in actuator space."""
    s = np.linspace(0.0, 1.0, nodes)
    solution = inverse_kinematics(machine, controlled, np.full(nodes, mode))
    assert solution.reachable.all()
    return Path(machine, make_interp_spline(s, solution.q_m, k=5), s, solution.pose)


def line_path(machine: Machine) -> Path:
    """A short regular path in working mode LLL."""
    return pose_path(machine, np.linspace(START, [1.05, 0.33, 0.88, 0.05, -0.02], NODES), 0)


def actuator_path(machine: Machine, q_m: np.ndarray, middle: np.ndarray) -> Path:
    """Interpolate actuators (NODES, 5), following the pose from that of the middle both ways."""
    half = NODES // 2
    forward, backward = (follow(machine, q[None], middle[None])[0][0] for q in (q_m[half:], q_m[half::-1]))
    s = np.linspace(0.0, 1.0, NODES)
    return Path(machine, make_interp_spline(s, q_m, k=5), s, np.concatenate([backward[:0:-1], forward]))


def ends_of(machine: Machine, path: Path, modes: tuple[int, int]) -> tuple[End, End]:
    """Call the ends of a path start and goal."""
    ends = []
    for k, mode in zip((0, -1), modes, strict=True):
        pose = path.pose(np.array([0.0, 1.0]))[k]
        ends.append(End(mode, pose, path.q(float(k == -1)), 1.0, 1.0, 1.0, 1.0))
    return ends[0], ends[1]


def determinant(machine: Machine, along: float) -> float:
    """Give det H on the line towards the singularity."""
    solution = inverse_kinematics(machine, (START + along * TOWARDS_SINGULARITY)[None], np.array([RLL]))
    return float(np.linalg.det(statics_matrix(machine, solution.pose, solution.q_m[:, :3]))[0])


def state(certificate: Certificate) -> Statement:
    """Say what a certificate states, as its file would."""
    assert certificate.bounds is not None
    tolerances = [
        None if one is None else StatedTolerance(one.eps_m, 0 if one.chain is None else len(one.chain.boxes))
        for one in (certificate.link_length, certificate.coordinates)
    ]
    return Statement(
        certificate.path_sha256,
        certificate.premises_sha256,
        len(certificate.chain.boxes),
        certificate.bounds,
        *tolerances,
        tuple(chains(certificate)),
    )
