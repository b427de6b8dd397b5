"""What a search for errors finds is verified by the re-check, on whichever machine."""

from collections.abc import Callable
from dataclasses import replace
from functools import partial

import numpy as np
import pytest

from pipeline.certify.examiner import build_error_examiner
from pipeline.certify.following.profile import prove_profile
from pipeline.certify.machines.tolerance import search_problem
from pipeline.certify.recheck import verifies
from pipeline.certify.result import ProvenChain, proven_chain
from pipeline.certify.search import Search, largest_error, new_search
from pipeline.config import Config
from pipeline.inclusion.closure import working_precision
from pipeline.inclusion.uncertainty import Uncertainty, of_actuators, of_everything
from pipeline.limits import error_proven_limits
from pipeline.machine import Machine
from pipeline.refine import Path
from tests.certify.paths import START, pose_path

_ERRORS: dict[str, Callable[[float], Uncertainty]] = {
    "drives": of_actuators(np.ones(5)),
    "one drive": of_actuators(np.eye(5)[4]),
    "calibration": of_everything,
}


def _short_path(machine: Machine, step: float = 0.02) -> Path:
    end = np.array(START) + step * np.array([1.0, 0.3, -0.7, 0.4, -0.2])
    return pose_path(machine, np.linspace(START, end, 6), 0, nodes=6)


def _other(machine: Machine, seed: int) -> Machine:
    """Draw a machine with rails and lengths of links that are up to 1 cm different."""
    random = np.random.default_rng(seed)
    rails, lengths = machine.rails_m, machine.lengths_m
    return replace(
        machine,
        rails_m=rails + random.uniform(-0.01, 0.01, rails.shape),
        lengths_m=lengths + random.uniform(-0.01, 0.01, lengths.shape),
    )


@pytest.mark.parametrize("errors", _ERRORS)
@pytest.mark.parametrize("seed", [0, 1])
def test_chains_of_the_largest_errors_are_verified(
    agder_config: Config, machine: Machine, errors: str, seed: int
) -> None:
    """With the limits kept, or, for calibration errors, on the branch: the errors found are those that are verified."""
    other = _other(machine, seed)
    path = _short_path(other)
    check = partial(verifies, agder_config, other, path)
    kind, within = _ERRORS[errors], errors != "calibration"
    with working_precision(64):
        problem = search_problem(other, path, check)
        keep = build_error_examiner(error_proven_limits(agder_config, other))
        search = new_search(problem, kind, keep, 0.02) if within else new_search(problem, kind)
        found = largest_error(search, 1e-3, 0.5)
        assert found.chain is not None
        assert check(proven_chain(found.chain, kind(found.proven_m), within_limits=within))
        assert not check(proven_chain(found.chain, kind(1.5 * found.proven_m), within_limits=within))


@pytest.fixture(scope="module")
def search(machine: Machine) -> Search:
    """Search what the short path bears on its branch."""
    return new_search(search_problem(machine, _short_path(machine)), _ERRORS["drives"], resolution=0.05)


def test_errors_become_smaller_until_a_chain_is_verified(search: Search) -> None:
    """And it is one for just these errors; where none is verified, none is found."""

    def at_most(eps: float) -> Search:
        def verify(chain: ProvenChain) -> bool:
            return max(chain.profile_m or chain.uncertainty.actuator_m) <= eps

        return replace(search, problem=replace(search.problem, verifies=verify))

    with working_precision(64):
        free = largest_error(search, 1e-3, 0.5)
        held = largest_error(at_most(0.96 * free.proven_m), 1e-3, 0.5)
        far = largest_error(at_most(0.5 * free.proven_m), 1e-3, 0.5)
        never = largest_error(at_most(-1.0), 1e-3, 0.5)
        profile = prove_profile(at_most(0.96 * free.proven_m), free.proven_m, within_limits=False)
    assert 0.94 * free.proven_m < held.proven_m <= 0.96 * free.proven_m
    assert 0.4 * free.proven_m < far.proven_m <= 0.5 * free.proven_m
    assert never.chain is None
    assert never.failure is not None
    assert "other arithmetic" in never.failure.reason.text
    assert profile is None or max(profile.profile_m or ()) <= 0.96 * free.proven_m
