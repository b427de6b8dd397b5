"""The table of following errors: rows, times, and who writes it."""

from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from pipeline.artifacts.layout import CERTIFICATE_JSON, FOLLOWING_CSV
from pipeline.certify.following.steps import FollowingProfile, at_ends, following_profile
from pipeline.certify.guess import point_box
from pipeline.certify.recheck import StatedFollowing, StatedTolerance
from pipeline.certify.result import ProvenChain
from pipeline.config import Config
from pipeline.export.csv import read_csv
from pipeline.inclusion.krawczyk import Box
from pipeline.inclusion.uncertainty import Uncertainty
from pipeline.machine import Machine
from pipeline.run import RunOptions, Stage, run_pipeline
from pipeline.run.makers.following import proven_following, table_of_motion, table_of_proof, times_at
from pipeline.run.product import Product
from pipeline.run.results import Results
from tests.run.fake_stages import FakeStages
from tests.run.short_results import make_path, make_trajectory

STOPPED = StatedTolerance(1e-3, 4, stopped_by=("kappa", 0.4))


def chain(profile_m: tuple[float, ...], *, within_limits: bool) -> ProvenChain:
    """Make up a chain of four boxes."""
    s = np.linspace(0.0, 1.0, 5)
    boxes = tuple(Box(a, b, np.zeros((4, 6)), np.ones(6)) for a, b in pairwise(s))
    joints = tuple(point_box(float(one), np.zeros(6)) for one in s)
    errors = Uncertainty(actuator_m=(min(profile_m),) * 5)
    return ProvenChain(errors, boxes, joints, within_limits=within_limits, profile_m=profile_m)


@pytest.fixture
def profile() -> FollowingProfile:
    """Join two profiles that change in different places."""
    chains = [chain((1e-3, 1e-3, 2e-3, 2e-3), within_limits=True), chain((4e-3, 3e-3, 3e-3, 5e-3), within_limits=False)]
    found = following_profile(chains)
    assert found is not None
    return found


def test_profiles_are_joined_where_either_changes(profile: FollowingProfile) -> None:
    """And nowhere else; a claim that was not proven is unknown, and without profiles there is nothing."""
    np.testing.assert_array_equal(profile.s, [0.0, 0.25, 0.5, 0.75, 1.0])
    np.testing.assert_array_equal(profile.within_limits_m, [1e-3, 1e-3, 2e-3, 2e-3])
    np.testing.assert_array_equal(profile.on_branch_m, [4e-3, 3e-3, 3e-3, 5e-3])
    one = following_profile([chain((1e-3, 1e-3, 1e-3, 2e-3), within_limits=False)])
    assert one is not None
    np.testing.assert_array_equal(one.s, [0.0, 0.75, 1.0])
    assert np.isnan(one.within_limits_m).all()
    assert following_profile([replace(chain((1e-3,) * 4, within_limits=True), profile_m=None)]) is None


def test_lines_between_rows_are_below_the_steps(profile: FollowingProfile) -> None:
    """At every s, whatever the steps."""
    s = np.linspace(0.0, 1.0, 997)
    for steps in (profile.within_limits_m, profile.on_branch_m):
        proven = steps[np.clip(np.searchsorted(profile.s, s, side="right") - 1, 0, len(steps) - 1)]
        assert (np.interp(s, profile.s, at_ends(steps)) <= proven + 1e-15).all()


def test_times_are_those_at_which_the_trajectory_is_there(machine: Machine) -> None:
    """To a nanosecond; at rest at the start the last moment, at the goal the first one."""
    trajectory = replace(make_trajectory(make_path(machine, 5)), dwell_s=(0.5, 0.25))
    s = np.array([0.0, 0.1, 0.5, 0.9, 1.0])
    t = times_at(trajectory, s)
    np.testing.assert_allclose(trajectory.s(t), s, atol=1e-9)
    assert (np.diff(t) > 0.0).all()
    assert t[2] == pytest.approx(1.5)


def test_the_proof_writes_the_table_and_the_motion_adds_its_times(
    tmp_path: Path, fast_config: Config, machine: Machine, profile: FollowingProfile
) -> None:
    """Neither writes one where nothing was proven."""
    results = Results(fast_config, machine, tmp_path)
    assert table_of_proof(results, None) == {}
    first = read_csv(table_of_proof(results, profile)[FOLLOWING_CSV].decode())
    assert list(first) == ["s", *(f"e{k}_m" for k in range(1, 6)), *(f"branch_e{k}_m" for k in range(1, 6))]
    np.testing.assert_allclose(first["e4_m"], [1e-3, 1e-3, 1e-3, 2e-3, 2e-3])
    np.testing.assert_allclose(first["branch_e1_m"], [4e-3, 3e-3, 3e-3, 3e-3, 5e-3])
    trajectory = make_trajectory(make_path(machine, 5))
    assert table_of_motion(results, trajectory) == {}
    (tmp_path / CERTIFICATE_JSON).write_text("{}")
    stated = SimpleNamespace(
        chains=[chain((1e-3, 2e-3, 2e-3, 2e-3), within_limits=True)], following=StatedFollowing({}, {"common": STOPPED})
    )
    results.keep(Stage.CERTIFY, stated)
    found = proven_following(results)
    assert found is not None
    assert found.stops == (("kappa", 0.4),)
    later = read_csv(table_of_motion(results, trajectory)[FOLLOWING_CSV].decode())
    assert list(later)[:2] == ["s", "t_s"]
    np.testing.assert_allclose(trajectory.s(later["t_s"]), later["s"], atol=1e-9)


def test_a_file_that_a_later_stage_completes_stays_its_own(
    tmp_path: Path, fast_config: Config, stages: FakeStages
) -> None:
    """It is written anew with the later stage, and nothing is outdated or damaged by that."""
    made = {"certify": 0, "retime": 0}
    rows = {row.stage: row for row in stages.specs}

    def proof(results: Results, monitor: object) -> Product:
        made["certify"] += 1
        product = rows[Stage.CERTIFY].make(results, monitor)
        return replace(product, files={**product.files, FOLLOWING_CSV: b"s\n0\n"})

    def motion(results: Results, monitor: object) -> Product:
        made["retime"] += 1
        return replace(rows[Stage.RETIME].make(results, monitor), completed={FOLLOWING_CSV: b"s,t_s\n0,0\n"})

    makers = {Stage.CERTIFY: proof, Stage.RETIME: motion}
    specs = tuple(replace(row, make=makers.get(row.stage, row.make)) for row in stages.specs)
    for _ in range(2):
        run_pipeline(fast_config, tmp_path, RunOptions(), None, specs)
        assert (tmp_path / FOLLOWING_CSV).read_bytes() == b"s,t_s\n0,0\n"
    assert made == {"certify": 1, "retime": 1}
    assert not list(tmp_path.glob(f"superseded/*/{FOLLOWING_CSV}"))
