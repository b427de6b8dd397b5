"""The proof of a path: the chain of boxes, the bounds over it, both ends, and on request the calibration tolerances."""

from dataclasses import replace
from functools import partial

import numpy as np

from pipeline.certify.bounds import combine_bounds
from pipeline.certify.chain import close_chain
from pipeline.certify.endpoints import check_ends
from pipeline.certify.examiner import build_examiner
from pipeline.certify.following.tolerances import search_following, searching_within_limits
from pipeline.certify.machines.tolerance import search_problem, search_tolerances
from pipeline.certify.premises import premises_sha256
from pipeline.certify.problem import build_problem
from pipeline.certify.reasons import ProofFailure
from pipeline.certify.recheck import verifies
from pipeline.certify.result import Certificate, path_sha256, proven_chain
from pipeline.config import Config
from pipeline.config.choices import Proof
from pipeline.errors import ForwardKinematicsError, NoSolutionError
from pipeline.inclusion.closure import working_precision
from pipeline.inclusion.uncertainty import CERTAIN
from pipeline.limits import proven_limits
from pipeline.machine.geometry import Machine
from pipeline.progress import QUIET, Monitor
from pipeline.refine.motion import kappa_along
from pipeline.refine.result import Path, require_path
from pipeline.route.regions.endpoints import Endpoint, task_endpoints

_SAMPLES = 2_001


def certify_path(config: Config, machine: Machine, path: Path, monitor: Monitor = QUIET) -> Certificate:
    """Prove that a path is one motion free of singularities, within its limits, from the start to the goal.

    Proven are the limits that the certificate bounds (`ProvenLimit`): the cap on kappa, the distances of links and
    rails, the forces that hold the machine at rest, travel, strokes and tilts, and the boxes to avoid. Since a
    path may touch boxes, and its limits of actuators and tilts, it is proven to pass them by no more than 1e-6 m or
    rad (`PROOF_ROUNDING_M`, `PROOF_ROUNDING_RAD`); the bounds of the certificate are wider by another 1e-5
    (`PROOF_SLACK_M`, `PROOF_SLACK_RAD`), so that other arithmetic can verify them.

    With `certify.what` "tolerances" the largest calibration errors for which the chain still closes are searched as
    well, and with "following" those of the actuators, too.

    Raises
    ------
    NoSolutionError
        If the path cannot be certified: where, and why; its diagnosis holds what was proven before.
    """
    ends = task_endpoints(config, machine)
    with working_precision(config.certify.precision_bits):
        certificate = prove_path(config, machine, path, ends, monitor)
        if certificate.failure is not None:
            raise _refusal(certificate, certificate.failure)
        problem = search_problem(machine, path, partial(verifies, config, machine, path))
        if config.certify.what == Proof.TOLERANCES:
            lengths, coordinates = search_tolerances(config.certify, problem, monitor)
            certificate = replace(certificate, link_length=lengths, coordinates=coordinates)
        if config.certify.what == Proof.FOLLOWING:
            with searching_within_limits(config, problem) as within:
                lengths, coordinates = search_tolerances(config.certify, problem, monitor)
                following = search_following(config, problem, within, monitor)
            certificate = replace(certificate, link_length=lengths, coordinates=coordinates, following=following)
    return certificate


def prove_path(
    config: Config, machine: Machine, path: Path, ends: tuple[Endpoint, Endpoint], monitor: Monitor = QUIET
) -> Certificate:
    """Prove a path as far as possible; the result says why it ends there.

    Raises
    ------
    ArgumentError
        If the path is not one of finite numbers: its arrays were changed after it was made.
    """
    require_path(path)
    problem, limits = build_problem(machine, path, config.certify.least_width), proven_limits(config, machine)
    chain = close_chain(problem, build_examiner(config.certify, limits, _kappa_sampled(path)), monitor)
    failure, misses = chain.failure, (np.inf, np.inf)
    if failure is None:
        misses, failure = check_ends(problem, chain.joints, ends)
    return Certificate(
        path_sha256=path_sha256(path),
        premises_sha256=premises_sha256(config),
        precision_bits=config.certify.precision_bits,
        chain=proven_chain(chain, CERTAIN),
        bounds=combine_bounds(limits, chain, misses) if chain.inclusions else None,
        failure=failure,
    )


def _kappa_sampled(path: Path) -> float:
    """Compute the largest kappa at samples: what the bound is compared with, never part of it."""
    try:
        return float(kappa_along(path, np.linspace(0.0, 1.0, _SAMPLES)).max())
    except ForwardKinematicsError:
        return np.inf


def _refusal(certificate: Certificate, failure: ProofFailure) -> NoSolutionError:
    return NoSolutionError(
        "certify",
        f"the path cannot be certified beyond s = {failure.s:.6f}: {failure.reason.text}",
        failure.reason.advice,
        {"status": certificate.verdict, "certificate": certificate, "s": failure.s},
    )
