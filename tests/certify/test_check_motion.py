"""`certify --check` verifies the motion of a run, too: what the summary states of it, there and back."""

import json
import pathlib
from collections.abc import Callable

import pytest

from pipeline.artifacts.layout import SUMMARY, TRAJECTORY_NPZ
from pipeline.artifacts.npz import npz_bytes
from pipeline.artifacts.results.trajectory import pack_trajectory
from pipeline.config import Config
from pipeline.machine import Machine
from pipeline.refine import Path
from pipeline.retime import Trajectory, prove_motion, way_back
from pipeline.retime.result import stretched
from pipeline.summary.trajectory import proven_part
from tests.certify.runs import Data, check
from tests.certify.test_check import refused
from tests.retime.proof.conftest import at_rest_at_both_ends


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
    there, back = (proven_part(prove_motion(one)) for one in (motion, way_back(own_task, motion)))
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
    other = moving(lambda section: section["back"]["proven"].update(law_sha256="0" * 64))
    assert other == ["way back: the proof is of this time law"]
    assert "does not state what is proven" in moving(lambda section: section.pop("proven"))[0]
