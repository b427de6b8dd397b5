"""`certify --check` on tolerances of following errors: what was proven is verified, and no more than that."""

import pathlib
import shutil
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from pipeline.certify import Tolerance, certify_path
from pipeline.certify.chain import close_chain
from pipeline.certify.following import BY_VELOCITY, COMMON, following_weights
from pipeline.certify.problem import build_problem
from pipeline.certify.recheck.claims.inventory import FOLLOWING
from pipeline.certify.result import proven_chain
from pipeline.config import Config
from pipeline.inclusion.closure import working_precision
from pipeline.inclusion.uncertainty import of_actuators
from pipeline.machine import Machine
from pipeline.refine import Path
from tests.certify.paths import NODES, START, pose_path
from tests.certify.runs import Data, check, forge, write_run
from tests.certify.test_check import refused

_PROVEN = {COMMON: 1e-3, BY_VELOCITY: 2e-3, "l3b": 2e-3}


@pytest.fixture(scope="module")
def proven_run(
    tmp_path_factory: pytest.TempPathFactory, own_task: Config, machine: Machine, goal: np.ndarray
) -> pathlib.Path:
    """Certify the short path with a tolerance of every kind, and write it as a run does."""
    path = pose_path(machine, np.linspace(START, goal, NODES), 0)
    following = {name: _prove(path, name, eps) for name, eps in _PROVEN.items()}
    certificate = replace(certify_path(own_task, machine, path), following=following)
    folder = tmp_path_factory.mktemp("following") / "true"
    write_run(folder, own_task, path, certificate)
    return folder


def _prove(path: Path, name: str, eps: float) -> Tolerance:
    uncertainty = of_actuators(following_weights(path.machine)[name])(eps)
    with working_precision(64):
        chain = close_chain(build_problem(path.machine, path, 1e-4, uncertainty))
    assert chain.failure is None
    return Tolerance(eps, 2.0 * eps, np.inf, proven_chain(chain, uncertainty))


@pytest.fixture
def following_run(proven_run: pathlib.Path, tmp_path: pathlib.Path) -> pathlib.Path:
    """Give a copy, to be forged."""
    return pathlib.Path(shutil.copytree(proven_run, tmp_path / "run"))


def test_true_tolerances_are_verified(following_run: pathlib.Path) -> None:
    """Each by its own chain, whose errors are shown."""
    result = check(following_run)
    assert result.exit_code == 0, result.output
    for shown in ("common 1 mm, by_velocity 2 mm, l3b 2 mm", "c1, c2, c3, l2b, l3b ± 2, 2, 2, 0.4, 0.4 mm"):
        assert shown in result.stdout


def _state_more(data: Data) -> None:
    data["tolerances"]["following"][COMMON]["proven_m"] = 5e-3


def _mean_more(data: Data) -> None:
    """State more, and say so of the chain as well: its boxes do not hold so much."""
    _state_more(data)
    data["chains"][1]["uncertainty"]["actuator_m"] = [5e-3] * 5


def _without_its_chain(data: Data) -> None:
    del data["chains"][2]


def _of_other_errors(data: Data) -> None:
    """Telescopes that are hardly off, in a chain of all actuators alike."""
    data["chains"][1]["uncertainty"]["actuator_m"][3:] = [1e-6, 1e-6]


def _of_another_kind(data: Data) -> None:
    stated = data["tolerances"]["following"]
    stated["c1"] = stated.pop("l3b")


def _unheard_of(data: Data) -> None:
    stated = data["tolerances"]["following"]
    stated["all"] = stated.pop("l3b")


def _twice(data: Data) -> None:
    data["chains"].append(data["chains"][1])


@pytest.mark.parametrize(
    "change", [_state_more, _without_its_chain, _of_other_errors, _of_another_kind, _unheard_of, _twice]
)
def test_what_the_chains_do_not_say_is_refused(following_run: pathlib.Path, change: Callable[[Data], None]) -> None:
    """Whatever else is right."""
    forge(following_run, change)
    assert FOLLOWING in refused(check(following_run))


def test_a_chain_that_claims_more_than_its_boxes_hold_is_refused(following_run: pathlib.Path) -> None:
    """The arithmetic finds it, not the book-keeping."""
    forge(following_run, _mean_more)
    wrong = refused(check(following_run))
    assert FOLLOWING not in wrong
    assert any("one regular pose" in claim for claim in wrong)


def test_errors_are_those_of_five_actuators(following_run: pathlib.Path) -> None:
    """Another number of them is a damaged file."""

    def four(data: Data) -> None:
        data["chains"][1]["uncertainty"]["actuator_m"].pop()

    forge(following_run, four)
    result = check(following_run)
    assert result.exit_code == 2
    assert "chains[1].uncertainty.actuator_m" in result.stderr
