"""Tolerances: the largest errors of calibration and of actuators for which the chain still closes, by bisection."""

from collections.abc import Callable
from dataclasses import replace

from pipeline.certify.chain import close_chain
from pipeline.certify.following import COMMON, following_weights
from pipeline.certify.monte_carlo import failing_eps
from pipeline.certify.problem import ProofProblem, build_problem
from pipeline.certify.result import ProvenChain, Tolerance, proven_chain
from pipeline.config import CertifyConfig
from pipeline.inclusion.uncertainty import Uncertainty, of_actuators, of_everything, of_lengths
from pipeline.machine.geometry import Machine
from pipeline.progress import QUIET, Monitor
from pipeline.refine.result import Path

_FIRST_M = 1e-4
_FIRST_FOLLOWING_M = 1e-3
"""The first error that is tried: of calibration, of actuators."""
_LEAST_M = 1e-7
_LEAST_WIDTH = 1e-4
"""A chain that closes for many machines does not need narrow boxes."""


def search_tolerances(
    options: CertifyConfig, machine: Machine, path: Path, monitor: Monitor = QUIET
) -> tuple[Tolerance, Tolerance]:
    """Search both tolerances: of link lengths alone, and of all lengths and coordinates together."""
    problem = build_problem(machine, path, _LEAST_WIDTH)
    lengths, coordinates = (largest_tolerance(options, problem, kind, monitor) for kind in (of_lengths, of_everything))
    return lengths, coordinates


def search_following(
    options: CertifyConfig, machine: Machine, path: Path, monitor: Monitor = QUIET
) -> dict[str, Tolerance]:
    """Search the largest errors of the actuators, of every kind: eps is that of the actuator with the largest."""
    problem, found, first = build_problem(machine, path, _LEAST_WIDTH), dict[str, Tolerance](), _FIRST_FOLLOWING_M
    for name, weights in following_weights(machine).items():
        found[name] = largest_tolerance(options, problem, of_actuators(weights), monitor, first)
        # Errors of fewer actuators, or of slower ones, leave the others more room.
        first = max(first, 2.0 * found[COMMON].eps_m)
    return found


def largest_tolerance(
    options: CertifyConfig,
    problem: ProofProblem,
    kind: Callable[[float], Uncertainty],
    monitor: Monitor = QUIET,
    first_m: float = _FIRST_M,
) -> Tolerance:
    """Double or halve eps until the tolerance is bracketed, then bisect it to `certify.tolerance_resolution`.

    The first error that is tried is `first_m`.
    """

    def prove(eps: float) -> ProvenChain | None:
        monitor.progress(f"trying an error of {1e3 * eps:.4g} mm")
        chain = close_chain(replace(problem, uncertainty=kind(eps)))
        return proven_chain(chain, kind(eps)) if chain.failure is None else None

    good, bad, proof, eps = 0.0, float("inf"), None, first_m
    while eps > _LEAST_M and bad > (1.0 + options.tolerance_resolution) * good:
        found = prove(eps)
        if found is None:
            bad = eps
        else:
            good, proof = eps, found
        eps = 2.0 * good if bad == float("inf") else (good + bad) / 2.0
    monitor.progress("searching for machines that fail")
    fails = failing_eps(problem.machine, problem.path, kind, options.monte_carlo_samples)
    return Tolerance(good, bad, fails, proof)
