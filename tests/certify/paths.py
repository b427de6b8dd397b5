"""Short paths whose certificates are known."""

from dataclasses import dataclass

import numpy as np
from scipy.interpolate import BSpline, make_interp_spline

from pipeline.artifacts.results.certificate.stored import chains
from pipeline.certify import Bounds, Certificate, Ranges
from pipeline.certify.chain import close_chain
from pipeline.certify.problem import build_problem
from pipeline.certify.recheck import StatedTolerance, Statement, verify
from pipeline.certify.result import ProvenChain, path_sha256
from pipeline.config import Config
from pipeline.inclusion.closure import working_precision
from pipeline.inclusion.uncertainty import CERTAIN
from pipeline.machine import Machine, inverse_kinematics, statics_matrix
from pipeline.machine.geometry import ACTUATORS, MODES
from pipeline.machine.kinematics import follow, newton
from pipeline.machine.samples import PoseSamples
from pipeline.refine import Path
from pipeline.route.regions.endpoints import Endpoint

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


def ends_of(machine: Machine, path: Path, modes: tuple[int, int]) -> tuple[Endpoint, Endpoint]:
    """Call the ends of a path start and goal."""
    ends = []
    for k, mode in zip((0, -1), modes, strict=True):
        pose = path.pose(np.array([0.0, 1.0]))[k]
        ends.append(Endpoint(mode, PoseSamples(machine, pose[None], path.q(float(k == -1))[None])))
    return ends[0], ends[1]


def other_solution(machine: Machine, q: np.ndarray, pose: np.ndarray) -> np.ndarray:
    """Find another pose for the same actuators."""
    random = np.random.default_rng(3)
    for _ in range(500):
        guess = pose + random.uniform(-1.0, 1.0, 6) * np.array([0.3, 0.3, 0.3, 0.8, 1.5, 0.8])
        found, miss = newton(machine, q[None], guess[None])
        if miss[0] < 1e-10 and np.abs(found[0] - pose).max() > 0.05 and np.abs(found[0]).max() < 3.0:
            return found[0]
    raise AssertionError("there is none near")


@dataclass(frozen=True, eq=False, kw_only=True)
class Jumping(Path):
    """A path with poses of another branch beyond s = 1/2: from there on (`before`), or only after it."""

    beyond: Path
    before: bool

    def pose(self, s: np.ndarray | float) -> np.ndarray:
        """Evaluate poses that all close, on two branches."""
        s = np.atleast_1d(s)
        far = s >= 0.5 if self.before else s > 0.5
        return np.where(far[:, None], self.beyond.pose(s), super().pose(s))


def two_branches(machine: Machine, line: Path) -> tuple[Path, Path]:
    """Give two paths with the same actuators, a knot at s = 1/2, and poses on two branches."""
    middle, pose = line.q(0.5), line.pose(np.array([0.5]))[0]
    s = np.array([0.0, 0.5, 1.0])
    q = middle + (s[:, None] - 0.5) * np.array([2e-3, 2e-3, 2e-3, 0.0, 0.0])
    spline = BSpline(np.array([0.0, *s, 1.0]), q, 1)
    poses = (newton(machine, q, np.tile(start, (3, 1)))[0] for start in (pose, other_solution(machine, middle, pose)))
    one, other = (Path(machine, spline, s, found) for found in poses)
    return one, other


def branching_chains(machine: Machine, line: Path) -> list[ProvenChain]:
    """Give chains of two proven boxes on different branches; the joint between them is on one, or on the other."""
    paths = two_branches(machine, line)
    with working_precision(64):
        first, second = (close_chain(build_problem(machine, path, 0.3)) for path in paths)
    boxes = (first.inclusions[0].box, second.inclusions[1].box)
    ends = (first.joints[0].box, second.joints[2].box)
    return [ProvenChain(CERTAIN, boxes, (ends[0], chain.joints[1].box, ends[1])) for chain in (first, second)]


def bounds_of(
    kappa: float = 31.0,
    distances_m: dict[str, float] | None = None,
    actuators_m: tuple[float, float] = (0.5, 1.5),
    tilt_deg: tuple[float, float] = (6.0, 3.0),
) -> Bounds:
    """Make up bounds."""
    distances = {"links 1 and 2a": 0.1} if distances_m is None else distances_m
    return Bounds(
        {
            "kappa": Ranges(("kappa",), np.array([[-np.inf, kappa]])),
            "det_sign": Ranges(("det_sign",), np.ones((1, 2))),
            "distance_m": Ranges(tuple(distances), np.array([[least, np.inf] for least in distances.values()])),
            "actuators_m": Ranges(ACTUATORS, np.tile(actuators_m, (5, 1))),
            "tilt_deg": Ranges(("rx", "rz"), np.array([[-np.inf, largest] for largest in tilt_deg])),
        },
        kappa_s=0.5,
        start_miss=1e-11,
        goal_miss=2e-11,
    )


def verified(config: Config, path: Path, chain: ProvenChain) -> dict[str, bool]:
    """Return which claims of a chain of the configured machine are verified."""
    stated = Statement(path_sha256(path), "", len(chain.boxes), bounds_of(), None, None, (chain,))
    end = Endpoint(0, PoseSamples(path.machine, chain.joints[0].pose[:1], path.q(0.0)[None]))
    claims = verify(config, path.machine, path, (end, end), stated)
    return {claim.what.removeprefix("configured machine: "): claim.verified for claim in claims}


def knotted(degree: int, multiplicity: int) -> BSpline:
    """Interpolate five columns by one piece, and put a knot at 1/2 so often."""
    s = np.linspace(0.0, 1.0, degree + 1)
    return make_interp_spline(s, np.sin(s[:, None] + np.arange(5.0)), k=degree).insert_knot(0.5, multiplicity)


def torn(spline: BSpline, by: float) -> BSpline:
    """Let a spline of degree 5 jump at s = 1/2, where its knot is as often as the degree plus one."""
    inside = np.full(6, 0.5)
    values = spline(0.5)
    coefficients = np.vstack([np.tile(values, (6, 1)), np.tile(values + by, (6, 1))])
    return BSpline(np.concatenate([np.zeros(6), inside, np.ones(6)]), coefficients, 5)


def determinant(machine: Machine, along: float) -> float:
    """Give det H on the line towards the singularity."""
    solution = inverse_kinematics(machine, (START + along * TOWARDS_SINGULARITY)[None], np.array([RLL]))
    return float(np.linalg.det(statics_matrix(machine, solution.pose, solution.q_m[:, :3]))[0])


def state(certificate: Certificate) -> Statement:
    """Return what a certificate states, as its file would."""
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
