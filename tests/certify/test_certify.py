"""The stage: a certificate of the real task, or a refusal that says where and what to change."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from pipeline.artifacts.results.certificate.stored import certificate_bytes, read_certificate
from pipeline.certify import Certificate, certify_path
from pipeline.certify.recheck import verify
from pipeline.config import Config
from pipeline.errors import NoSolutionError, UsageError
from pipeline.machine import Machine
from pipeline.refine import Path
from pipeline.route.regions.endpoints import task_endpoints


def test_a_path_from_start_to_goal_is_certified(own_task: Config, machine: Machine, own_path: Path) -> None:
    """Within the real limits, and its ends are where the inverse kinematics put them."""
    certificate = certify_path(own_task, machine, own_path)
    assert certificate.verdict == "certified"
    assert certificate.bounds is not None
    assert certificate.bounds.start_miss < 1e-9
    assert certificate.bounds.goal_miss < 1e-9
    assert certificate.bounds.det_sign == 1


@pytest.mark.parametrize(
    ("changes", "reason", "advice"),
    [
        ({"refine": {"kappa_max": 20.0}}, "kappa is not proven below its cap 20", "kappa_max"),
        ({"task": {"tilt_max_deg": 1.0}}, "rx is not proven to stay within its limit", "tilt_margin_deg"),
    ],
)
def test_a_refusal_says_where_and_why(
    own_task: Config, machine: Machine, own_path: Path, changes: dict[str, dict[str, float]], reason: str, advice: str
) -> None:
    """With what was proven before it."""
    sections = {name: getattr(own_task, name).model_copy(update=change) for name, change in changes.items()}
    with pytest.raises(NoSolutionError, match="cannot be certified beyond s = ") as refused:
        certify_path(own_task.model_copy(update=sections), machine, own_path)
    assert reason in refused.value.reason
    assert advice in refused.value.advice
    assert refused.value.diagnosis["status"] == "not certified"
    assert isinstance(refused.value.diagnosis["certificate"], Certificate)


def test_a_goal_that_is_missed_is_reported(agder_config: Config, machine: Machine, own_path: Path) -> None:
    """The path is a motion, but not the task's."""
    with pytest.raises(NoSolutionError, match="the goal is missed by"):
        certify_path(agder_config, machine, own_path)


def test_a_certificate_is_read_as_it_was_written(
    tmp_path_factory: pytest.TempPathFactory, own_task: Config, machine: Machine, own_path: Path
) -> None:
    """Bit by bit, so that what is read is verified."""
    certificate = certify_path(own_task, machine, own_path)
    file = tmp_path_factory.mktemp("run") / "certificate.json"
    file.write_bytes(certificate_bytes(certificate, {"seconds": 1.0}))
    stored = read_certificate(file)
    for box, read in zip(certificate.chain.boxes, stored.chains[0].boxes, strict=True):
        assert (box.first, box.last) == (read.first, read.last)
        np.testing.assert_array_equal(box.pose, read.pose)
        np.testing.assert_array_equal(box.radius, read.radius)
    claims = verify(own_task, machine, own_path, task_endpoints(own_task, machine), stored)
    assert all(claim.verified for claim in claims)


@pytest.mark.parametrize("content", [b"{}", b"no", b'{"verdict": "not certified"}', None])
def test_a_file_that_is_not_a_certificate_is_reported(
    tmp_path_factory: pytest.TempPathFactory, content: bytes | None
) -> None:
    """And so is one of a path that was refused."""
    file = tmp_path_factory.mktemp("run") / "certificate.json"
    if content is not None:
        file.write_bytes(content)
    with pytest.raises(UsageError, match=r"certificate\.json"):
        read_certificate(file)


def test_the_wrong_branch_at_an_end_is_reported(
    machine: Machine, line: Path, prove: Callable[..., Certificate]
) -> None:
    """A machine that is assembled the other way round cannot be at the start of this path."""
    certificate = prove(replace(machine, triangle_sign=-machine.triangle_sign), line)
    assert certificate.failure is not None
    assert "triangle" in certificate.failure.reason.text
