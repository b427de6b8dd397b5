"""Calibration tolerances: the largest errors of the machine with which the chain still closes, by bisection."""

from collections.abc import Callable
from dataclasses import replace

from pipeline.certify.chain import close_chain, examine_nothing
from pipeline.certify.failure import failing_eps
from pipeline.certify.result import Certificate, ProvenChain, Tolerance, proven_chain
from pipeline.config import Config
from pipeline.inclusion.closure import geometry
from pipeline.inclusion.pieces import pieces
from pipeline.inclusion.uncertainty import Uncertainty, of_everything, of_lengths
from pipeline.machine.geometry import Machine
from pipeline.progress import Progress, silent
from pipeline.refine.result import Path

_FIRST_M = 1e-4
_LEAST_M = 1e-7
_LEAST_WIDTH = 1e-4
"""Where the chain closes for many machines at once, boxes need not be narrow."""


def search_tolerances(
    config: Config, machine: Machine, path: Path, certificate: Certificate, progress: Progress = silent
) -> Certificate:
    """Add both tolerances to a certificate: of link lengths alone, and of every coordinate at once."""
    lengths, coordinates = (
        largest_tolerance(config, machine, path, kind, progress) for kind in (of_lengths, of_everything)
    )
    return replace(certificate, link_length=lengths, coordinates=coordinates)


def largest_tolerance(
    config: Config,
    machine: Machine,
    path: Path,
    kind: Callable[[float], Uncertainty],
    progress: Progress = silent,
) -> Tolerance:
    """Double or halve eps until it is enclosed, then bisect it to `certify.tolerance_resolution`."""
    balls, exact_pieces = geometry(machine), pieces(path.spline)

    def prove(eps: float) -> ProvenChain | None:
        progress(f"trying an error of {1e3 * eps:.4g} mm")
        uncertainty = kind(eps)
        chain = close_chain(balls, path, exact_pieces, _LEAST_WIDTH, examine_nothing, uncertainty)
        return proven_chain(chain, uncertainty) if chain.broken is None else None

    good, bad, proof, eps = 0.0, float("inf"), None, _FIRST_M
    while eps > _LEAST_M and bad > (1.0 + config.certify.tolerance_resolution) * good:
        found = prove(eps)
        if found is None:
            bad = eps
        else:
            good, proof = eps, found
        eps = 2.0 * good if bad == float("inf") else (good + bad) / 2.0
    progress("looking for machines that fail")
    fails = failing_eps(machine, path, kind, config.certify.monte_carlo_samples)
    return Tolerance(good, bad, fails, proof)
