"""`certify --check` verifies the motion of a run, too: what the summary states of it, there and back."""

import json
import pathlib
from collections.abc import Callable

import pytest

from pipeline.artifacts.layout import BACK_CSV, SUMMARY, TRAJECTORY_CSV, TRAJECTORY_NPZ
from pipeline.artifacts.npz import npz_bytes
from pipeline.artifacts.results.trajectory import pack_trajectory
from pipeline.config import Config
from pipeline.machine import Machine
from pipeline.refine import Path
from pipeline.retime import Trajectory, law_sha256, prove_motion, way_back
from pipeline.retime.result import stretched
from pipeline.summary.trajectory import proven_part
from tests.certify.runs import Data, check
from tests.certify.test_check import refused
from tests.retime.proof.conftest import at_rest_at_both_ends, of_degree_two


@pytest.fixture(scope="module")
def motion(machine: Machine, true_run: pathlib.Path, own_task: Config) -> Trajectory:
    """Drive the path of the true run, slowly."""
    from pipeline.run.reading import open_results

    path: Path = open_results(true_run).refinement.path
    slow = at_rest_at_both_ends(path, 10.0)
    return stretched(slow, 10.0)


@pytest.fixture(scope="module")
def sections(motion: Trajectory, own_task: Config) -> Data:
    """State what is proven of it and of its way back."""
    there, back = (proven_part(prove_motion(one, loads=True)) for one in (motion, way_back(own_task, motion)))
    return {"trajectory": {"status": "done", **there, "back": {"status": "done", **back}}}


@pytest.fixture
def moving(run: pathlib.Path, motion: Trajectory, sections: Data) -> Callable[[Callable[[Data], object]], list[str]]:
    """Write the run with its motion, its summary changed; give the claims that are refused."""

    def changed(change: Callable[[Data], object]) -> list[str]:
        from pipeline.artifacts.files import json_bytes

        data = json.loads(json_bytes(sections))
        change(data["trajectory"])
        (run / TRAJECTORY_NPZ).write_bytes(npz_bytes(pack_trajectory(motion)))
        (run / SUMMARY).write_bytes(json_bytes(data))
        result = check(run)
        if result.exit_code == 2:
            return [result.stderr]
        assert (result.exit_code == 0) == (refused(result) == []), result.output
        return refused(result)

    return changed


def test_a_true_motion_is_verified_and_forged_ones_are_not(
    moving: Callable[[Callable[[Data], object]], list[str]],
) -> None:
    """There and back, each by itself; a summary that states nothing cannot be verified."""
    assert moving(lambda section: None) == []
    halved = moving(lambda section: section["proven"].update(jerk=[0.5 * part for part in section["proven"]["jerk"]]))
    assert halved == ["trajectory: jerk stays within its bound and limit at every instant"]
    weaker = moving(lambda section: section["proven"]["peak"].update(force=[1.0] * 5))
    assert weaker == ["trajectory: force stays within its bound and limit at every instant"]
    other = moving(lambda section: section["back"]["proven"].update(law_sha256="0" * 64))
    assert other == ["way back: the proof is of this time law"]
    assert "does not state what is proven" in moving(lambda section: section.update(proven="all"))[0]


def test_a_motion_of_which_nothing_is_stated_is_refused(
    run: pathlib.Path, moving: Callable[[Callable[[Data], object]], list[str]]
) -> None:
    """Its files say that there is one, whatever the summary does; one that has no law is refused, too."""
    unproven = ["trajectory: the motion is proven", "way back: the motion is proven"]
    (run / BACK_CSV).touch()
    assert moving(lambda section: section.clear()) == unproven
    assert "gantry-tau retime CONFIG --force" in check(run).stdout
    (run / SUMMARY).unlink()
    assert refused(check(run)) == unproven
    (run / TRAJECTORY_NPZ).unlink()
    assert refused(check(run)) == unproven
    (run / BACK_CSV).unlink()
    assert check(run).exit_code == 0
    (run / TRAJECTORY_CSV).touch()
    assert refused(check(run)) == unproven[:1]


def test_the_configuration_says_whether_accelerations_may_jump(
    run: pathlib.Path, motion: Trajectory, own_task: Config
) -> None:
    """A law of degree two, of which everything else that is stated is true, jumps with `retime.jerk: on` only."""
    from pipeline.artifacts.files import json_bytes

    abrupt = of_degree_two(motion, 10.0 * motion.duration_s)
    everything = {name: [1.0] * 5 for name in ("velocity", "acceleration", "jerk", "force")}
    stated = {"proven": {**everything, "link_force": [1.0] * 6, "law_sha256": law_sha256(abrupt)}}
    (run / TRAJECTORY_NPZ).write_bytes(npz_bytes(pack_trajectory(abrupt)))
    (run / SUMMARY).write_bytes(json_bytes({"trajectory": {**stated, "back": stated}}))
    assert own_task.retime.jerk
    wrong = ["trajectory: the motion goes from rest to rest without jumps", "way back: the motion is proven"]
    assert refused(check(run)) == wrong
