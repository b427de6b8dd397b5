"""Calibration tolerances: the largest errors for which the chain still closes, by bisection."""

from collections.abc import Callable
from dataclasses import replace

from pipeline.certify.chain import close_chain
from pipeline.certify.monte_carlo import failing_eps
from pipeline.certify.problem import ProofProblem, build_problem
from pipeline.certify.result import ProvenChain, Tolerance, proven_chain
from pipeline.config import CertifyConfig
from pipeline.inclusion.uncertainty import Uncertainty, of_everything, of_lengths
from pipeline.machine.geometry import Machine
from pipeline.progress import QUIET, Monitor
from pipeline.refine.result import Path

_FIRST_M = 1e-4
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


def largest_tolerance(
    options: CertifyConfig,
    problem: ProofProblem,
    kind: Callable[[float], Uncertainty],
    monitor: Monitor = QUIET,
) -> Tolerance:
    """Double or halve eps until the tolerance is bracketed, then bisect it to `certify.tolerance_resolution`."""

    def prove(eps: float) -> ProvenChain | None:
        monitor.progress(f"trying an error of {1e3 * eps:.4g} mm")
        chain = close_chain(replace(problem, uncertainty=kind(eps)))
        return proven_chain(chain, kind(eps)) if chain.failure is None else None

    good, bad, proof, eps = 0.0, float("inf"), None, _FIRST_M
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
