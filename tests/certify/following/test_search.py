"""The search for following errors: what it finds is proven, a tenth more is not, and limits ask for less."""

from dataclasses import replace
from functools import partial

import numpy as np
import pytest

from pipeline.certify.chain import accept_any, close_chain
from pipeline.certify.examiner import build_error_examiner
from pipeline.certify.following.broken_limits import breaking_errors
from pipeline.certify.following.profile import prove_profile
from pipeline.certify.following.tolerances import search_following, searching_within_limits, tilt_reserve_deg
from pipeline.certify.machines.tolerance import search_problem
from pipeline.certify.problem import build_problem
from pipeline.certify.recheck import verifies
from pipeline.certify.result import FollowingTolerances, ProvenChain
from pipeline.certify.search import Search, largest_error, new_search
from pipeline.config import Config
from pipeline.inclusion.closure import working_precision
from pipeline.inclusion.uncertainty import CERTAIN, of_actuators
from pipeline.limits import error_proven_limits
from pipeline.machine import Machine
from pipeline.machine.kinematics import newton
from pipeline.machine.samples import PoseSamples
from pipeline.parallel import THREADS
from pipeline.refine import Path
from tests.certify.paths import START, pose_path

_ALL = np.ones(5)


@pytest.fixture(scope="module")
def near(machine: Machine) -> Path:
    """Go a short way in few pieces, with the nearest links a little farther apart than is required."""
    return pose_path(machine, np.linspace(START, [1.026, 0.306, 0.896, 0.01, -0.004], 8), 0, nodes=8)


@pytest.fixture(scope="module")
def tight(agder_config: Config, near: Path) -> tuple[Config, Machine]:
    """Ask for distances that the path keeps with 2 mm to spare."""
    s = np.linspace(0.0, 1.0, 201)
    nearest = float(PoseSamples(near.machine, near.pose(s), near.q(s)).link_distances_m.min())
    least = nearest - 2e-3
    clearance = agder_config.machine.clearance.model_copy(update={"link_link_m": least})
    machine = agder_config.machine.model_copy(update={"clearance": clearance})
    certify = agder_config.certify.model_copy(update={"tolerance_resolution": 0.5, "monte_carlo_samples": 1})
    config = agder_config.model_copy(update={"machine": machine, "certify": certify})
    return config, replace(near.machine, link_link_m=least)


def _search(path: Path, config: Config | None = None, machine: Machine | None = None) -> Search:
    """Search errors of all actuators alike, with limits if a configuration is given."""
    keep = accept_any
    if config is not None and machine is not None:
        keep = build_error_examiner(error_proven_limits(config, machine))
    return new_search(build_problem(machine or path.machine, path, 1e-3), of_actuators(_ALL), keep, 0.03)


def test_a_tenth_more_than_was_found_is_not_proven(near: Path, tight: tuple[Config, Machine]) -> None:
    """Within limits, and on the branch; limits ask for less; the chain is of the size that is stated."""
    with working_precision(64):
        searches = _search(near), _search(near, *tight)
        branch, within = (largest_error(search, 1e-3, 0.5) for search in searches)
        for search, found in zip(searches, (branch, within), strict=True):
            assert found.chain is not None
            assert 0.0 < found.proven_m < found.refuted_m <= 1.03 * found.proven_m
            assert search.close(1.1 * found.proven_m).failure is not None
            proven = [float(e.mid()) for box in found.chain.inclusions for e in box.following.errors]
            assert found.proven_m == min(proven)
        stops = [found.failure for found in (branch, within)]
        assert all(stop is not None and 0.0 <= stop.s <= 1.0 for stop in stops)
        assert [stop.reason.limit.split()[0] for stop in stops if stop is not None] == ["regularity", "links"]
    assert within.proven_m < 0.5 * branch.proven_m


def test_seen_errors_break_a_limit_and_proven_ones_do_not(near: Path, tight: tuple[Config, Machine]) -> None:
    """In every corner, at many s; and what was seen to break a limit does."""
    config, machine = tight
    with working_precision(64):
        proven = largest_error(_search(near, config, machine), 1e-3, 0.5).proven_m
    seen = breaking_errors(error_proven_limits(config, machine), near, _ALL)
    assert proven < seen.eps_m < 4.0 * proven
    corners = 2.0 * ((np.arange(32)[:, None] >> np.arange(5)) & 1) - 1.0
    s = np.linspace(0.0, 1.0, 41)

    def least_m(eps: float) -> float:
        found = []
        for corner in corners:
            q = near.q(s) + eps * corner
            pose, miss = newton(machine, q, near.pose(s))
            assert (miss < 1e-9).all()
            found.append(PoseSamples(machine, pose, q).link_distances_m.min())
        return min(found)

    assert least_m(seen.eps_m) < machine.link_link_m < least_m(proven)


def test_a_path_that_touches_a_limit_bears_nothing_within_it(near: Path, tight: tuple[Config, Machine]) -> None:
    """The search ends, and says so; on its branch the path bears what it did."""
    config, machine = tight
    touched = replace(machine, link_link_m=machine.link_link_m + 2e-3)
    seen = breaking_errors(error_proven_limits(config, touched), near, _ALL)
    with working_precision(64):
        found = largest_error(_search(near, config, touched), seen.eps_m, seen.s)
    assert found.proven_m == 0.0
    assert found.chain is None
    assert 0.0 < found.refuted_m < 1e-3


def test_no_errors_reproduce_the_chain_of_the_configured_machine(near: Path) -> None:
    """Box by box, to the last bit; a memory changes nothing."""
    with working_precision(64):
        plain = close_chain(build_problem(near.machine, near, 1e-3))
        remembered = _search(near).close(0.0)
    assert [one.box.last for one in plain.inclusions] == [one.box.last for one in remembered.inclusions]
    for one, other in zip(plain.inclusions, remembered.inclusions, strict=True):
        np.testing.assert_array_equal(one.box.radius, other.box.radius)
        np.testing.assert_array_equal(one.box.pose, other.box.pose)


def test_a_profile_is_at_least_what_all_of_the_path_bears(near: Path, tight: tuple[Config, Machine]) -> None:
    """Everywhere, but for how finely it is searched; somewhere more; and it is proven as one chain."""
    search = _search(near, *tight)
    with working_precision(64):
        everywhere = largest_error(search, 1e-3, 0.5)
        chain = prove_profile(_search(near, *tight), everywhere.proven_m, within_limits=True)
        assert chain is not None
        assert chain.profile_m is not None
        problem = replace(
            search.problem,
            memory=None,
            uncertainty=CERTAIN,
            profile_m={
                next(piece.first for piece in search.problem.pieces if box.last <= piece.last): eps
                for box, eps in zip(chain.boxes, chain.profile_m, strict=True)
            },
        )
        joint = problem.errors_over(problem.pieces[0], problem.pieces[0].last)
    assert min(chain.profile_m) > 0.85 * everywhere.proven_m
    assert max(chain.profile_m) > 1.02 * min(chain.profile_m)
    assert max(joint.actuator_m) == min(problem.profile_m[piece.first] for piece in problem.pieces[:2])
    assert chain.within_limits
    assert chain.uncertainty.actuator_m == (min(chain.profile_m),) * 5


def test_the_tilts_reserve_covers_all_corners(near: Path) -> None:
    """Rx and rz are off the path by no more than is stated, and by hardly less."""
    eps = 5e-4
    with working_precision(64):
        reserve = tilt_reserve_deg(_search(near).close(eps))
    s, worst = np.linspace(0.0, 1.0, 41), np.zeros(2)
    for corner in 2.0 * ((np.arange(32)[:, None] >> np.arange(5)) & 1) - 1.0:
        pose, _ = newton(near.machine, near.q(s) + eps * corner, near.pose(s))
        worst = np.maximum(worst, np.rad2deg(np.abs(pose - near.pose(s))[:, [3, 5]].max(axis=0)))
    assert (worst <= reserve).all()
    assert (np.array(reserve) < 1.1 * worst).all()


@pytest.mark.slow
def test_every_kind_of_error_is_searched_for_both_claims(
    near: Path, tight: tuple[Config, Machine], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Slower actuators off by less, or fewer of them off, leave the others more room; limits ask for less.

    In one process the same is found as in two.
    """
    config, machine = tight
    options = config.certify.model_copy(update={"following_coordinate_m": 2e-5})
    config = config.model_copy(update={"certify": options})

    def search() -> FollowingTolerances:
        problem = search_problem(machine, near, partial(verifies, config, machine, near))
        with working_precision(64), searching_within_limits(config, problem) as within:
            return search_following(config, problem, within)

    found = search()
    monkeypatch.setenv(THREADS, "1")
    alone = search()
    names = ["common", "by_velocity", "c1", "c2", "c3", "l2b", "l3b"]
    assert list(found.within_limits) == list(found.on_branch) == names
    for name in names:
        within, branch = found.within_limits[name], found.on_branch[name]
        assert 0.0 < within.eps_m < within.refuted_m
        assert within.eps_m < min(within.fails_m, branch.eps_m)
        assert branch.eps_m < branch.fails_m
        assert within.chain is not None
        assert within.chain.within_limits
    late = found.within_limits["by_velocity"]
    assert late.late_s == pytest.approx(late.eps_m / 0.5)
    assert late.chain is not None
    assert late.chain.uncertainty.actuator_m[3] == pytest.approx(0.2 * late.eps_m)
    assert found.calibrated is not None
    assert found.calibrated.eps_m < found.on_branch["common"].refuted_m
    assert set(found.profiles) == {"within_limits", "on_branch"}
    for one, other in zip(_chains(found), _chains(alone), strict=True):
        assert (one.uncertainty, one.profile_m) == (other.uncertainty, other.profile_m)
        assert [box.last for box in one.boxes] == [box.last for box in other.boxes]


def _chains(found: FollowingTolerances) -> list[ProvenChain]:
    tolerances = (*found.within_limits.values(), *found.on_branch.values())
    assert set(found.profiles) == {"within_limits", "on_branch"}
    return [one.chain for one in tolerances if one.chain is not None] + [
        found.profiles[key] for key in sorted(found.profiles)
    ]
