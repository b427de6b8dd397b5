"""Calibration tolerances: the largest errors for which the chain still closes."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from pipeline.certify.monte_carlo import failing_eps
from pipeline.certify.problem import Memory, ProofProblem, build_problem
from pipeline.certify.result import ProvenChain, Tolerance, proven_chain
from pipeline.certify.search import largest_error, new_search
from pipeline.config import CertifyConfig
from pipeline.inclusion.uncertainty import Uncertainty, of_everything, of_lengths
from pipeline.machine.geometry import Machine
from pipeline.progress import QUIET, Monitor
from pipeline.refine.motion import kappa_along
from pipeline.refine.result import Path

_FIRST_M = 1e-3
_LEAST_WIDTH = 1e-4
"""A chain that closes for many machines does not need narrow boxes."""
_SAMPLES = 401


def search_problem(machine: Machine, path: Path, verifies: Callable[[ProvenChain], bool] | None = None) -> ProofProblem:
    """Build what searches for errors of a path share, and what verifies the chains they find."""
    return replace(build_problem(machine, path, _LEAST_WIDTH), memory=Memory(), verifies=verifies)


def search_tolerances(
    options: CertifyConfig, problem: ProofProblem, monitor: Monitor = QUIET
) -> tuple[Tolerance, Tolerance]:
    """Search both tolerances: of link lengths alone, and of all lengths and coordinates together."""
    lengths = largest_tolerance(options, problem, of_lengths, (_FIRST_M, monitor))
    return lengths, largest_tolerance(options, problem, of_everything, (lengths.eps_m or _FIRST_M, monitor))


def largest_tolerance(
    options: CertifyConfig,
    problem: ProofProblem,
    kind: Callable[[float], Uncertainty],
    known: tuple[float, Monitor] = (_FIRST_M, QUIET),
) -> Tolerance:
    """Bracket a tolerance to `certify.tolerance_resolution`, from a likely size of it."""
    likely_m, monitor = known
    monitor.progress("searching for machines that fail")
    fails = failing_eps(problem.machine, problem.path, kind, options.monte_carlo_samples)
    search = new_search(problem, kind, resolution=options.tolerance_resolution)
    found = largest_error(search, likely_m, critical_s(problem.path), monitor)
    proof = None if found.chain is None else proven_chain(found.chain, kind(found.proven_m))
    return Tolerance(found.proven_m, found.refuted_m, fails, proof, stopped_by=found.failure)


def critical_s(path: Path) -> float:
    """Find where errors are most likely to matter first: where kappa is largest."""
    s = np.linspace(0.0, 1.0, _SAMPLES)
    return float(s[np.argmax(kappa_along(path, s))])
