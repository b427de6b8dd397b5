"""The proof of a path: the chain of boxes, the bounds over it, both ends, and on request the calibration tolerances."""

import numpy as np

from pipeline.certify.chain import JUMP, NO_INCLUSION, NO_POSE, Break, Chain, close_chain
from pipeline.certify.endpoints import check_end
from pipeline.certify.limits import Facts, build_limits, examiner, pair_name
from pipeline.certify.premises import premises_sha256
from pipeline.certify.result import Bounds, Certificate, path_sha256, proven_chain
from pipeline.certify.tolerance import search_tolerances
from pipeline.config import Config
from pipeline.errors import ForwardKinematicsError, NoSolutionError
from pipeline.inclusion.closure import Geometry, geometry, working_precision
from pipeline.inclusion.distances import build_pairs
from pipeline.inclusion.pieces import Piece, pieces
from pipeline.inclusion.uncertainty import CERTAIN
from pipeline.machine.geometry import Machine
from pipeline.progress import Progress, silent
from pipeline.refine.motion import kappa_along
from pipeline.refine.result import Path
from pipeline.route.regions.endpoints import Endpoint, task_endpoints

_SAMPLES = 2_001
_ADVICE = {
    NO_POSE: "Give the path a wider berth: lower refine.kappa_max, or raise refine.nodes.",
    NO_INCLUSION: "The path meets a singularity there, or comes too near one: lower refine.kappa_max, or raise "
    "refine.nodes; certify.least_width may be smaller.",
    JUMP: "Raise refine.nodes: the path is not one motion.",
    "kappa": "Raise refine.kappa_max, or give the path more room.",
    "link": "Raise refine.clearance_margin_m.",
    "rx": "Raise refine.tilt_margin_deg.",
    "rz": "Raise refine.tilt_margin_deg.",
}
_ANY_ADVICE = "Raise refine.nodes, and refine again."


def certify_path(config: Config, machine: Machine, path: Path, progress: Progress = silent) -> Certificate:
    """Prove that a path is one motion free of singularities, within its limits, from the start to the goal.

    These are the caps on kappa, the distances of links and rails, travel, strokes and tilts. Boxes to avoid are none of
    them, and of a limit the path may touch `limits.ROUNDING` is given away.

    With `certify.what` "tolerances" the largest calibration errors with which it still is one are searched, too.

    Raises
    ------
    NoSolutionError
        Where the path cannot be certified: the place and the reason; its diagnosis holds what was proven before.
    """
    ends = task_endpoints(config, machine)
    with working_precision(config.certify.precision_bits):
        certificate = prove_path(config, machine, path, ends, progress)
        if certificate.broken is not None:
            raise _refusal(certificate, certificate.broken)
        if config.certify.what == "tolerances":
            certificate = search_tolerances(config, machine, path, certificate, progress)
    return certificate


def prove_path(
    config: Config, machine: Machine, path: Path, ends: tuple[Endpoint, Endpoint], progress: Progress = silent
) -> Certificate:
    """Prove a path as far as it goes; why it goes no further is in the result."""
    balls, exact_pieces = geometry(machine), pieces(path.spline)
    limits = build_limits(config, machine, _kappa_sampled(path))
    examine = examiner(machine, balls, limits)
    chain = close_chain(balls, path, exact_pieces, config.certify.least_width, examine, progress=progress)
    broken, misses = chain.broken, (np.inf, np.inf)
    if broken is None:
        misses, broken = _check_ends(machine, balls, exact_pieces, chain, ends)
    return Certificate(
        path_sha256=path_sha256(path),
        premises_sha256=premises_sha256(config),
        precision_bits=config.certify.precision_bits,
        chain=proven_chain(chain, CERTAIN),
        bounds=_bounds(machine, chain, misses) if chain.facts else None,
        broken=broken,
    )


def _check_ends(
    machine: Machine, balls: Geometry, exact_pieces: list[Piece], chain: Chain[Facts], ends: tuple[Endpoint, Endpoint]
) -> tuple[tuple[float, float], Break | None]:
    start_miss, start = check_end(machine, balls, exact_pieces[0], chain.joints[0], ends[0], "start")
    goal_miss, goal = check_end(machine, balls, exact_pieces[-1], chain.joints[-1], ends[1], "goal")
    return (start_miss, goal_miss), start or goal


def _bounds(machine: Machine, chain: Chain[Facts], misses: tuple[float, float]) -> Bounds:
    facts, pairs = chain.facts, build_pairs(machine)
    kappa = np.array([fact.kappa for fact in facts])
    worst = chain.inclusions[int(kappa.argmax())].box
    actuators = np.stack([fact.actuators_m for fact in facts])
    signs = {fact.det_sign for fact in facts}
    return Bounds(
        kappa=float(kappa.max()),
        kappa_s=(worst.first + worst.last) / 2.0,
        det_sign=signs.pop() if len(signs) == 1 else 0,
        pairs=tuple(pair_name(pairs, pair) for pair in range(len(pairs.first))),
        distances_m=np.min([fact.distances_m for fact in facts], axis=0),
        actuators_m=np.column_stack([actuators[:, :, 0].min(axis=0), actuators[:, :, 1].max(axis=0)]),
        tilt_rad=np.max([fact.tilt_rad for fact in facts], axis=0),
        start_miss=misses[0],
        goal_miss=misses[1],
    )


def _kappa_sampled(path: Path) -> float:
    """Largest kappa at samples: what the bound is compared with, never part of it."""
    try:
        return float(kappa_along(path, np.linspace(0.0, 1.0, _SAMPLES)).max())
    except ForwardKinematicsError:
        return np.inf


def _refusal(certificate: Certificate, broken: Break) -> NoSolutionError:
    advice = next((text for start, text in _ADVICE.items() if broken.why.startswith(start)), _ANY_ADVICE)
    return NoSolutionError(
        "certify",
        f"the path cannot be certified beyond s = {broken.s:.6f}: {broken.why}",
        advice,
        {"status": certificate.verdict, "certificate": certificate, "s": broken.s},
    )
