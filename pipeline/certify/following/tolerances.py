"""All tolerances of following errors: within the limits, on the branch alone, over s, and beside calibration errors."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace

import numpy as np
from flint import arb

from pipeline.certify.chain import Chain, Examiner, accept_any
from pipeline.certify.examiner import build_error_examiner
from pipeline.certify.following.broken_limits import Broken, breaking_errors
from pipeline.certify.following.profile import prove_profile
from pipeline.certify.following.second_process import Call, begun
from pipeline.certify.following.weights import BY_VELOCITY, COMMON, following_weights
from pipeline.certify.machines.tolerance import critical_s, search_problem
from pipeline.certify.monte_carlo import failing_eps
from pipeline.certify.problem import ProofProblem
from pipeline.certify.result import FollowingTolerances, ProvenChain, Tolerance, proven_chain
from pipeline.certify.search import Search, largest_error, new_search
from pipeline.config import Config
from pipeline.inclusion.closure import working_precision
from pipeline.inclusion.uncertainty import Uncertainty, of_actuators
from pipeline.limits import error_proven_limits
from pipeline.machine.geometry import ACTUATORS, Machine
from pipeline.machine.pose import TILT_COLUMNS
from pipeline.progress import QUIET, Monitor
from pipeline.refine.result import Path

_FIRST_M = 1e-3
_RESERVE_MARGIN, _RESERVE_SLACK_DEG = 1.01, 1e-6
"""What reserves are enlarged by, so that other arithmetic can verify them."""


@dataclass(frozen=True, eq=False)
class _Given:
    """What all searches share."""

    config: Config
    problem: ProofProblem

    def search(self, kind: Callable[[float], Uncertainty], examine: Examiner = accept_any) -> Search:
        return new_search(self.problem, kind, examine, self.config.certify.tolerance_resolution)


_Within = tuple[dict[str, Tolerance], ProvenChain | None]
"""Errors within limits, by their kinds, and over s."""


@contextmanager
def searching_within_limits(config: Config, problem: ProofProblem) -> Iterator[Call[_Within]]:
    """Begin to search the errors within limits, in a second process if there is a processor for it.

    The other searches need nothing of that one, and what is found is the same.
    """
    with begun(_search_within_limits, config, problem.machine, problem.path, problem.verifies) as call:
        yield call


def search_following(
    config: Config, problem: ProofProblem, within: Call[_Within], monitor: Monitor = QUIET
) -> FollowingTolerances:
    """Search the largest errors of the actuators, of every kind: eps is that of the actuator with the largest.

    Each is searched twice: with the limits of kappa, distances and joints kept (`within`), and with none, so that the
    motion merely stays regular and on its branch.
    """
    given, machine, branch = _Given(config, problem), problem.machine, dict[str, Tolerance]()
    common = given.search(of_actuators(np.ones(len(ACTUATORS))))
    for name, weights in following_weights(machine).items():
        kind = of_actuators(weights)
        search = common if name == COMMON else given.search(kind)
        monitor.progress("searching for machines that fail")
        fails = failing_eps(machine, problem.path, kind, config.certify.monte_carlo_samples)
        likely_m = branch[COMMON].eps_m if branch else 0.0
        branch[name] = _late(_closing(search, (likely_m or _FIRST_M, fails), monitor), name, machine)
    calibrated = _calibrated(given, branch[COMMON], monitor)
    profile = prove_profile(common, branch[COMMON].eps_m or _FIRST_M, within_limits=False, monitor=monitor)
    monitor.progress("searching errors within limits")
    given_again = config, machine, problem.path, problem.verifies
    found, profile_within = within.result(lambda: _search_within_limits(*given_again, monitor))
    profiles = {"within_limits": profile_within, "on_branch": profile}
    proven = {name: chain for name, chain in profiles.items() if chain is not None}
    return FollowingTolerances(found, branch, calibrated, proven)


def _search_within_limits(
    config: Config,
    machine: Machine,
    path: Path,
    verifies: Callable[[ProvenChain], bool] | None,
    monitor: Monitor = QUIET,
) -> _Within:
    """Search errors of every kind, and those of all actuators alike over s, with the limits kept."""
    with working_precision(config.certify.precision_bits):
        given, limits = _Given(config, search_problem(machine, path, verifies)), error_proven_limits(config, machine)
        keep, found = build_error_examiner(limits), dict[str, Tolerance]()
        common = given.search(of_actuators(np.ones(len(ACTUATORS))), keep)
        for name, weights in following_weights(machine).items():
            seen = breaking_errors(limits, path, weights)
            search = common if name == COMMON else given.search(of_actuators(weights), keep)
            found[name] = _late(_within_limits(search, seen, monitor), name, machine)
        likely_m = found[COMMON].eps_m
        profile = prove_profile(common, likely_m, within_limits=True, monitor=monitor) if likely_m > 0.0 else None
        return found, profile


def _within_limits(search: Search, seen: Broken, monitor: Monitor) -> Tolerance:
    """Search the largest errors within limits, and what the tilts are off by then."""
    likely_m = seen.eps_m if np.isfinite(seen.eps_m) else _FIRST_M
    found = largest_error(search, likely_m, seen.s, monitor)
    if found.chain is None:
        return Tolerance(0.0, found.refuted_m, seen.eps_m, None, stopped_by=found.failure)
    proof = proven_chain(found.chain, search.kind(found.proven_m), within_limits=True)
    reserve = tilt_reserve_deg(found.chain)
    return Tolerance(found.proven_m, found.refuted_m, seen.eps_m, proof, reserve, stopped_by=found.failure)


def _closing(search: Search, known_m: tuple[float, float], monitor: Monitor) -> Tolerance:
    """Search the largest errors of a kind for which the chain closes, from a guess; some machine fails at the other."""
    likely_m, fails_m = known_m
    found = largest_error(search, likely_m, critical_s(search.problem.path), monitor)
    proof = None if found.chain is None else proven_chain(found.chain, search.kind(found.proven_m))
    return Tolerance(found.proven_m, found.refuted_m, fails_m, proof, stopped_by=found.failure)


def _late(tolerance: Tolerance, name: str, machine: Machine) -> Tolerance:
    """Say by how much actuators at their velocity limits may be early or late."""
    if name != BY_VELOCITY:
        return tolerance
    return replace(tolerance, late_s=tolerance.eps_m / float(machine.velocity_mps.max()))


def _calibrated(given: _Given, alone: Tolerance, monitor: Monitor) -> Tolerance | None:
    """Search the largest errors of all actuators beside the configured calibration errors; None if these are zero.

    The machine as configured is one of those: what fails with errors of actuators alone fails beside others, too.
    """
    options = given.config.certify
    beside = Uncertainty(options.following_length_m, options.following_coordinate_m)
    if not beside.calibration:
        return None

    def kind(eps_m: float) -> Uncertainty:
        return replace(beside, actuator_m=(eps_m,) * 5)

    return _closing(given.search(kind), (alone.eps_m or _FIRST_M, alone.fails_m), monitor)


def tilt_reserve_deg(chain: Chain) -> tuple[float, float]:
    """Bound how far rx and rz are from those of the path, over all boxes: |P| A + 2 k, with r in place of k.

    Other arithmetic has larger k, but verifies that they are below r.
    """
    found = []
    for column in TILT_COLUMNS:
        off = [box.following.moved[column] + 2 * arb(float(box.box.radius[column])) for box in chain.inclusions]
        largest = max(float(value.abs_upper()) for value in off)
        found.append(_RESERVE_MARGIN * float(np.rad2deg(largest)) + _RESERVE_SLACK_DEG)
    return found[0], found[1]
