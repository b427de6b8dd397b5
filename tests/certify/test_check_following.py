"""`certify --check` on tolerances of following errors: what was proven is verified, and no more than that."""

import pathlib
import shutil
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from scipy.interpolate import PPoly

from pipeline.artifacts.layout import CERTIFICATE_JSON, FOLLOWING_CSV
from pipeline.artifacts.results.certificate.stored import read_certificate
from pipeline.artifacts.results.following import TABLE, TIMES, following_files, table_claims
from pipeline.certify import certify_path
from pipeline.certify.chain import accept_any
from pipeline.certify.examiner import build_error_examiner
from pipeline.certify.following import BY_VELOCITY, COMMON, following_weights
from pipeline.certify.following.profile import prove_profile
from pipeline.certify.following.steps import following_profile
from pipeline.certify.following.tolerances import tilt_reserve_deg
from pipeline.certify.problem import build_problem
from pipeline.certify.recheck.claims.errors import RESERVE
from pipeline.certify.recheck.claims.inventory import FOLLOWING, PROFILES
from pipeline.certify.result import FollowingTolerances, Tolerance, proven_chain
from pipeline.certify.search import new_search
from pipeline.config import Config
from pipeline.inclusion.closure import working_precision
from pipeline.inclusion.uncertainty import Uncertainty, of_actuators
from pipeline.limits import error_proven_limits
from pipeline.machine import Machine
from pipeline.refine import Path
from pipeline.retime import Trajectory
from pipeline.run import open_results
from pipeline.run.makers.following import times_at
from tests.certify.paths import START, pose_path
from tests.certify.runs import Data, check, forge, write_run
from tests.certify.test_check import refused

_WITHIN = {COMMON: 5e-4, "l3b": 1e-3}
_BRANCH = {COMMON: 1e-3, BY_VELOCITY: 2e-3, "l3b": 2e-3}


@pytest.fixture(scope="module")
def proven_run(
    tmp_path_factory: pytest.TempPathFactory, own_task: Config, machine: Machine, goal: np.ndarray
) -> pathlib.Path:
    """Certify a short path of few pieces with tolerances of both claims and both profiles, and write it as runs do."""
    path = pose_path(machine, np.linspace(START, goal, 8), 0, nodes=8)
    certificate = replace(certify_path(own_task, machine, path), following=_prove_all(own_task, path))
    folder = tmp_path_factory.mktemp("following") / "true"
    write_run(folder, own_task, path, certificate)
    return folder


def _prove_all(config: Config, path: Path) -> FollowingTolerances:
    keep = build_error_examiner(error_proven_limits(config, path.machine))
    with working_precision(64):
        within = {name: _prove(config, path, name, eps) for name, eps in _WITHIN.items()}
        branch = {name: _prove(None, path, name, eps) for name, eps in _BRANCH.items()}
        profiles = {}
        for name, examine in (("within_limits", keep), ("on_branch", accept_any)):
            search = new_search(build_problem(path.machine, path, 1e-3), of_actuators(np.ones(5)), examine, 0.1)
            profiles[name] = prove_profile(search, 3e-3, within_limits=examine is keep)
            assert profiles[name] is not None
        beside = Uncertainty(1e-4, 2e-5, (5e-4,) * 5)
        chain = new_search(build_problem(path.machine, path, 1e-3), lambda eps: beside, accept_any, 0.1).close(1.0)
    assert chain.failure is None
    calibrated = Tolerance(5e-4, 1e-3, np.inf, proven_chain(chain, beside))
    return FollowingTolerances(within, branch, calibrated, profiles)


def _prove(config: Config | None, path: Path, name: str, eps: float) -> Tolerance:
    """Prove a tolerance; with a configuration, within its limits."""
    kind = of_actuators(following_weights(path.machine)[name])
    keep = accept_any if config is None else build_error_examiner(error_proven_limits(config, path.machine))
    chain = new_search(build_problem(path.machine, path, 1e-3), kind, keep, 0.1).close(eps)
    assert chain.failure is None
    proof = proven_chain(chain, kind(eps), within_limits=config is not None)
    return Tolerance(eps, 2.0 * eps, np.inf, proof, None if config is None else tilt_reserve_deg(chain))


@pytest.fixture
def following_run(proven_run: pathlib.Path, tmp_path: pathlib.Path) -> pathlib.Path:
    """Give a copy, to be forged."""
    return pathlib.Path(shutil.copytree(proven_run, tmp_path / "run"))


def test_true_tolerances_are_verified(following_run: pathlib.Path) -> None:
    """Each by its own chain, whose errors and claim are shown."""
    result = check(following_run)
    assert result.exit_code == 0, result.output
    for shown in (
        "common within limits 0.5 mm, l3b within limits 1 mm, common 1 mm, by_velocity 2 mm, l3b 2 mm",
        "c1, c2, c3, l2b, l3b ± 2, 2, 2, 0.4, 0.4 mm",
        "0.5, 0.5, 0.5, 0.5, 0.5 mm, limits kept: kappa, distances, joint angles and boxes to avoid keep their limits",
        "lengths ± 0.1, coordinates ± 0.02; c1, c2, c3, l2b, l3b ± 0.5",
        "over s mm, limits kept: each box holds one regular pose",
    ):
        assert shown in result.stdout


def _within(data: Data) -> Data:
    return data["tolerances"]["following_within_limits"]


def _branch(data: Data) -> Data:
    return data["tolerances"]["following_on_branch"]


def _state_more(data: Data) -> None:
    _branch(data)[COMMON]["proven_m"] *= 1.1


def _state_more_within_limits(data: Data) -> None:
    _within(data)[COMMON]["proven_m"] *= 1.1


def _state_more_beside_calibration(data: Data) -> None:
    data["tolerances"]["following_calibrated"]["length_m"] *= 1.1


def _without_its_chain(data: Data) -> None:
    del data["chains"][2]


def _of_other_errors(data: Data) -> None:
    """Telescopes that are hardly off, in a chain of all actuators alike."""
    data["chains"][1]["uncertainty"]["actuator_m"][3:] = [1e-6, 1e-6]


def _of_another_kind(data: Data) -> None:
    _branch(data)["c1"] = _branch(data).pop("l3b")


def _unheard_of(data: Data) -> None:
    _branch(data)["all"] = _branch(data).pop("l3b")


def _twice(data: Data) -> None:
    data["chains"].append(data["chains"][1])


def _branch_for_limits(data: Data) -> None:
    """State of what merely stays on its branch that limits are kept."""
    data["chains"][3]["within_limits"] = True


@pytest.mark.parametrize(
    "change",
    [
        _state_more,
        _state_more_within_limits,
        _state_more_beside_calibration,
        _without_its_chain,
        _of_other_errors,
        _of_another_kind,
        _unheard_of,
        _twice,
        _branch_for_limits,
    ],
)
def test_what_the_chains_do_not_say_is_refused(following_run: pathlib.Path, change: Callable[[Data], None]) -> None:
    """Whatever else is right."""
    forge(following_run, change)
    assert FOLLOWING in refused(check(following_run))


def test_a_chain_that_claims_more_than_its_boxes_hold_is_refused(following_run: pathlib.Path) -> None:
    """Numbers that agree with one another are not enough: the arithmetic finds it."""

    def mean_more(data: Data) -> None:
        _branch(data)[COMMON]["proven_m"] = 1.5e-3
        data["chains"][3]["uncertainty"]["actuator_m"] = [1.5e-3] * 5

    forge(following_run, mean_more)
    wrong = refused(check(following_run))
    assert FOLLOWING not in wrong
    assert any("one regular pose" in claim or "share a branch" in claim for claim in wrong)


@pytest.mark.parametrize("profile", [-1, -2])
def test_a_profile_raised_at_one_knot_is_refused(following_run: pathlib.Path, profile: int) -> None:
    """The boxes there do not hold a tenth more."""

    def raise_one(data: Data) -> None:
        errors = data["chains"][profile]["profile_m"]
        most = int(np.argmax(errors))
        errors[most] *= 1.1

    forge(following_run, raise_one)
    wrong = refused(check(following_run))
    assert PROFILES not in wrong
    assert any("over s" in claim for claim in wrong)


def test_a_table_with_larger_errors_is_refused(following_run: pathlib.Path) -> None:
    """At a single s, in a single column; the table that belongs to the certificate is verified."""
    profile = following_profile(read_certificate(following_run / CERTIFICATE_JSON).chains)
    assert profile is not None
    text = (following_run / FOLLOWING_CSV).read_text()
    assert refused(check(following_run)) == []
    rows = [line.split(",") for line in text.splitlines()]
    rows[2][4] = f"{1.001 * float(rows[2][4]):.12f}"
    (following_run / FOLLOWING_CSV).write_text("\n".join(map(",".join, rows)) + "\n")
    result = check(following_run)
    assert refused(result) == [TABLE]
    assert f"line 3, {text.splitlines()[0].split(',')[4]}: {float(rows[2][4]):.12g}; proven " in result.stdout
    (following_run / FOLLOWING_CSV).write_text("s\nzero\n")
    assert refused(check(following_run)) == [TABLE]
    (following_run / FOLLOWING_CSV).unlink()
    result = check(following_run)
    assert refused(result) == [TABLE]
    assert "following.csv is missing" in result.stderr


def test_times_of_the_table_are_those_of_the_trajectory(following_run: pathlib.Path) -> None:
    """At every row; something other than a number is never a time."""
    results = open_results(following_run)
    trajectory = Trajectory(results.refinement.path, PPoly([[-2.0], [3.0], [0.0], [0.0]], [0.0, 1.0]))
    stated = results.certificate.chains
    profile = following_profile(stated)
    assert profile is not None

    def wrong(t_s: np.ndarray, known: Trajectory | None) -> list[str]:
        (text,) = (content for content in following_files(profile, t_s).values())
        (following_run / FOLLOWING_CSV).write_bytes(text)
        return [f"{one.what}: {one.found}" for one in table_claims(following_run, stated, known) if not one.verified]

    times = times_at(trajectory, profile.s)
    assert wrong(times, trajectory) == wrong(times, None) == []
    early = times - np.where(np.arange(len(times)) == len(times) - 1, 1e-3, 0.0)
    assert wrong(early, trajectory)[0].startswith(f"{TIMES}: line {len(times) + 1}, t_s: at ")
    assert len(wrong(times + 0.1, trajectory)) == 1
    words = times.astype(str)
    words[1] = "abc"
    for known in (trajectory, None):
        assert wrong(words, known) == [f"{TIMES}: line 3, t_s: abc is not a number"]
    assert len(wrong(times[::-1], None)) == 1


def test_every_claim_that_fails_is_named_and_comes_last(following_run: pathlib.Path) -> None:
    """With what was found, where the table ends."""
    forge(following_run, _twice)
    (following_run / FOLLOWING_CSV).unlink()
    result = check(following_run)
    wrong = refused(result)
    assert len(wrong) > 1
    assert all(claim in result.stderr.replace("\n", " ") for claim in wrong)
    assert f"{len(wrong)} of " in result.stderr
    marks = [line.split("│")[2].strip() for line in result.stdout.splitlines() if line.count("│") > 3]
    marks = [mark for mark in marks if mark]
    assert marks == sorted(marks, reverse=True)


def test_a_profile_states_the_least_of_its_errors(following_run: pathlib.Path) -> None:
    """What it is for anywhere."""

    def more(data: Data) -> None:
        data["chains"][-1]["uncertainty"]["actuator_m"] = [1.0] * 5

    forge(following_run, more)
    assert refused(check(following_run)) == [PROFILES]


def test_a_reserve_that_is_too_small_is_refused(following_run: pathlib.Path) -> None:
    """By as little as what the proof adds to it."""

    def less(data: Data) -> None:
        reserve = _within(data)[COMMON]["tilt_reserve_deg"]
        reserve[0] *= 0.9

    forge(following_run, less)
    (wrong,) = refused(check(following_run))
    assert RESERVE in wrong


def test_errors_are_those_of_five_actuators(following_run: pathlib.Path) -> None:
    """Another number of them is a damaged file."""

    def four(data: Data) -> None:
        data["chains"][1]["uncertainty"]["actuator_m"].pop()

    forge(following_run, four)
    result = check(following_run)
    assert result.exit_code == 2
    assert "chains[1].uncertainty.actuator_m" in result.stderr
