"""All tolerances of following errors: within the limits, on the branch alone, over s, and beside calibration errors."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from pipeline.arrays import FloatArray
from pipeline.certify.chain import Chain, Examiner, accept_any
from pipeline.certify.examiner import build_error_examiner
from pipeline.certify.following.broken_limits import Broken, breaking_errors
from pipeline.certify.following.profile import prove_profile
from pipeline.certify.following.search import Search, largest_error, new_search
from pipeline.certify.following.second_process import begun
from pipeline.certify.following.weights import BY_VELOCITY, COMMON, following_weights
from pipeline.certify.monte_carlo import failing_eps
from pipeline.certify.problem import Memory, ProofProblem, build_problem
from pipeline.certify.result import FollowingTolerances, ProvenChain, Tolerance, proven_chain
from pipeline.config import Config
from pipeline.inclusion.closure import working_precision
from pipeline.inclusion.uncertainty import Uncertainty, of_actuators
from pipeline.limits import error_proven_limits
from pipeline.machine.geometry import Machine
from pipeline.machine.pose import TILT_COLUMNS
from pipeline.progress import QUIET, Monitor
from pipeline.refine.motion import kappa_along
from pipeline.refine.result import Path

_FIRST_M = 1e-3
_LEAST_WIDTH = 1e-4
_SAMPLES = 401
_RESERVE_MARGIN, _RESERVE_SLACK_DEG = 1.01, 1e-6
"""What reserves are enlarged by, so that other arithmetic can verify them."""


@dataclass(frozen=True, eq=False)
class _Path:
    """What all searches share."""

    config: Config
    problem: ProofProblem
    critical_s: float

    def search(self, kind: Callable[[float], Uncertainty], examine: Examiner) -> Search:
        return new_search(self.problem, kind, examine, self.config.certify.tolerance_resolution)


def search_following(config: Config, machine: Machine, path: Path, monitor: Monitor = QUIET) -> FollowingTolerances:
    """Search the largest errors of the actuators, of every kind: eps is that of the actuator with the largest.

    Each is searched twice: with the limits of kappa, distances and joints kept, and with none, so that the motion
    merely stays regular and on its branch. With two processors the first searches run in a second process, the others
    and the profiles here: neither needs anything of the other, and what is found is the same.
    """
    given = _given(config, machine, path)
    with begun(_search_within_limits_apart, config, machine, path) as apart:
        branch = dict[str, Tolerance]()
        for name, weights in following_weights(machine).items():
            likely_m = branch[COMMON].eps_m if branch else 0.0
            branch[name] = _late(_on_branch(given, weights, likely_m or _FIRST_M, monitor), name, machine)
        calibrated = _calibrated(given, branch[COMMON], monitor)
        likely_m = branch[COMMON].eps_m or _FIRST_M
        keep = build_error_examiner(error_proven_limits(config, machine))
        profiles = {
            name: _profile(given, examine, likely_m, monitor)
            for name, examine in (("within_limits", keep), ("on_branch", accept_any))
        }
        monitor.progress("searching errors within limits")
        within = apart.result(lambda: _search_within_limits(given, monitor))
    proven = {name: chain for name, chain in profiles.items() if chain is not None}
    return FollowingTolerances(within, branch, calibrated, proven)


def _given(config: Config, machine: Machine, path: Path) -> _Path:
    problem = replace(build_problem(machine, path, _LEAST_WIDTH), memory=Memory())
    s = np.linspace(0.0, 1.0, _SAMPLES)
    return _Path(config, problem, float(s[np.argmax(kappa_along(path, s))]))


def _search_within_limits_apart(config: Config, machine: Machine, path: Path) -> dict[str, Tolerance]:
    """Search within limits in a process of its own."""
    with working_precision(config.certify.precision_bits):
        return _search_within_limits(_given(config, machine, path), QUIET)


def _search_within_limits(given: _Path, monitor: Monitor) -> dict[str, Tolerance]:
    """Search errors of every kind with the limits kept."""
    machine, path = given.problem.machine, given.problem.path
    limits = error_proven_limits(given.config, machine)
    keep, found = build_error_examiner(limits), dict[str, Tolerance]()
    for name, weights in following_weights(machine).items():
        seen = breaking_errors(limits, path, weights)
        found[name] = _late(_within_limits(given, weights, keep, seen, monitor), name, machine)
    return found


def _within_limits(given: _Path, weights: FloatArray, keep: Examiner, seen: Broken, monitor: Monitor) -> Tolerance:
    """Search the largest errors within limits, and what the tilts are off by then."""
    likely_m, kind = seen.eps_m if np.isfinite(seen.eps_m) else _FIRST_M, of_actuators(weights)
    found = largest_error(given.search(kind, keep), likely_m, seen.s, monitor)
    if found.chain is None:
        return Tolerance(0.0, found.refuted_m, seen.eps_m, None)
    proof = proven_chain(found.chain, kind(found.proven_m), within_limits=True)
    return Tolerance(found.proven_m, found.refuted_m, seen.eps_m, proof, tilt_reserve_deg(found.chain))


def _on_branch(given: _Path, weights: FloatArray, likely_m: float, monitor: Monitor) -> Tolerance:
    """Search the largest errors for which the chain closes, whatever limits are broken."""
    monitor.progress("searching for machines that fail")
    problem, samples, kind = given.problem, given.config.certify.monte_carlo_samples, of_actuators(weights)
    fails = failing_eps(problem.machine, problem.path, kind, samples)
    return _closing(given, kind, (likely_m, fails), monitor)


def _closing(
    given: _Path, kind: Callable[[float], Uncertainty], known_m: tuple[float, float], monitor: Monitor
) -> Tolerance:
    """Search the largest errors of a kind for which the chain closes, from a guess; some machine fails at the other."""
    likely_m, fails_m = known_m
    found = largest_error(given.search(kind, accept_any), likely_m, given.critical_s, monitor)
    proof = None if found.chain is None else proven_chain(found.chain, kind(found.proven_m))
    return Tolerance(found.proven_m, found.refuted_m, fails_m, proof)


def _late(tolerance: Tolerance, name: str, machine: Machine) -> Tolerance:
    """Say by how much actuators at their velocity limits may be early or late."""
    if name != BY_VELOCITY:
        return tolerance
    return replace(tolerance, late_s=tolerance.eps_m / float(machine.velocity_mps.max()))


def _profile(given: _Path, examine: Examiner, likely_m: float, monitor: Monitor) -> ProvenChain | None:
    """Prove errors over s; None if some s bears none."""
    search = given.search(of_actuators(np.ones(5)), examine)
    return prove_profile(search, likely_m, within_limits=examine is not accept_any, monitor=monitor)


def _calibrated(given: _Path, alone: Tolerance, monitor: Monitor) -> Tolerance | None:
    """Search the largest errors of all actuators beside the configured calibration errors; None if these are zero.

    The machine as configured is one of those: what fails with errors of actuators alone fails beside others, too.
    """
    options = given.config.certify
    beside = Uncertainty(options.following_length_m, options.following_coordinate_m)
    if not beside.calibration:
        return None

    def kind(eps_m: float) -> Uncertainty:
        return replace(beside, actuator_m=(eps_m,) * 5)

    return _closing(given, kind, (alone.eps_m or _FIRST_M, alone.fails_m), monitor)


def tilt_reserve_deg(chain: Chain) -> tuple[float, float]:
    """Bound how far rx and rz are from those of the path, over all boxes: |P| A + 2 k."""
    found = []
    for column in TILT_COLUMNS:
        off = [box.following.moved[column] + 2 * box.image[column] for box in chain.inclusions]
        largest = max(float(value.abs_upper()) for value in off)
        found.append(_RESERVE_MARGIN * float(np.rad2deg(largest)) + _RESERVE_SLACK_DEG)
    return found[0], found[1]
