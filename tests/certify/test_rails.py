"""Certificates of motions on rails that are off X: proven, checked again, and refused for other rails."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path as FilePath

import numpy as np
import pytest

from pipeline.certify import certify_path
from pipeline.config import Config
from pipeline.inclusion.uncertainty import of_everything, of_lengths
from pipeline.machine import build_machine
from pipeline.pose_error import bound_pose_error, sample_pose_error
from pipeline.refine import Path
from tests.certify.paths import START, pose_path
from tests.certify.runs import check, prove_tolerance, write_run
from tests.pose_error.conftest import EVERYTHING, bound_at

SLOPES = {"machine.rails.0.slopes": (0.005, -0.003), "machine.rails.1.slopes": (-0.004, 0.005)}
"""As far off as can be; rail 3 is parallel."""


@pytest.fixture(scope="module")
def sloping(own_task: Config, vary: Callable[..., Config]) -> Config:
    """Give the machine of the short path rails that are off X, which links keep a distance from."""
    return vary(own_task, {**SLOPES, "machine.clearance.link_rail_m": 0.05})


@pytest.fixture(scope="module")
def path(sloping: Config, goal: np.ndarray) -> Path:
    """Go straight from its start to its goal."""
    return pose_path(build_machine(sloping.machine), np.linspace(START, goal, 11), 0, 11)


def test_what_is_proven_is_verified_and_nothing_of_other_rails(
    sloping: Config, path: Path, vary: Callable[..., Config], tmp_path: FilePath
) -> None:
    """With tolerances of lengths and coordinates; the same certificate says nothing of rails a micrometre off."""
    certificate = replace(
        certify_path(sloping, path.machine, path),
        link_length=prove_tolerance(path, of_lengths(1e-4)),
        coordinates=prove_tolerance(path, of_everything(2e-5)),
    )
    write_run(tmp_path / "true", sloping, path, certificate)
    assert check(tmp_path / "true").exit_code == 0
    other = vary(sloping, {"machine.rails.0.slopes": (0.004999, -0.003)})
    write_run(tmp_path / "other", other, replace(path, machine=build_machine(other.machine)), certificate)
    assert check(tmp_path / "other").exit_code != 0


def test_the_tool_is_off_by_no_more_than_is_proven(path: Path) -> None:
    """Drives and geometry off together: no sample exceeds the bound."""
    found = bound_pose_error(path, EVERYTHING)
    s = found.edges[::8]
    sampled = sample_pose_error(path, EVERYTHING, s)
    position, angle = bound_at(found, s)
    assert (sampled.position_m <= position).all()
    assert (sampled.rotation_rad <= angle).all()
    assert (position <= 1.5 * sampled.position_m).all()
