"""The proven error of the tool: no sample exceeds it, and it is little more than the largest."""

from dataclasses import replace

import numpy as np
import pytest

from pipeline.errors import NoSolutionError
from pipeline.inclusion.uncertainty import CERTAIN
from pipeline.machine import Machine
from pipeline.machine.kinematics import newton
from pipeline.measured.perturbed import perturbed
from pipeline.pose_error import PoseError, bound_pose_error, sample_pose_error
from pipeline.pose_error.bound import WIDEST
from pipeline.pose_error.samples import rotation_angle
from pipeline.refine import Path
from tests.pose_error.conftest import DRIVES, EVERYTHING, bound_at

SHARP = 1.05


def _places(found: PoseError, n: int) -> np.ndarray:
    """Take places all along the path, the edges of the intervals among them."""
    return np.unique(np.concatenate([found.edges, np.linspace(0.0, 1.0, n)]))


def test_the_bound_is_above_every_sample_and_near_the_largest(line: Path, of_drives: PoseError) -> None:
    """Some 10,000 samples, every corner of the errors at each place: position and rotation within a twentieth."""
    s = _places(of_drives, 200)
    sampled = sample_pose_error(line, DRIVES, s)
    position, angle = bound_at(of_drives, s)
    assert 32 * len(s) >= 10_000
    assert (sampled.position_m <= position).all()
    assert (sampled.rotation_rad <= angle).all()
    assert of_drives.position_m.max() <= SHARP * sampled.position_m.max()
    assert of_drives.rotation_rad.max() <= SHARP * sampled.rotation_rad.max()


def test_drives_and_geometry_may_be_off_together(line: Path, of_everything: PoseError) -> None:
    """Corners that climb to the largest error, and random ones, stay below the bound; it is not far above them."""
    s = of_everything.edges[::8]
    sampled = sample_pose_error(line, EVERYTHING, s)
    position, angle = bound_at(of_everything, s)
    assert (sampled.position_m <= position).all()
    assert (sampled.rotation_rad <= angle).all()
    assert (position <= 1.5 * sampled.position_m).all()


def test_machines_drawn_at_random_stay_within_the_bound(machine: Machine, line: Path, of_everything: PoseError) -> None:
    """Those of simulated measurements, scaled so that their largest error is the one that is allowed."""
    s = np.linspace(0.0, 1.0, 41)
    q, nominal = line.q(s), line.pose(s)
    position, angle = bound_at(of_everything, s)
    random = np.random.default_rng(5)
    for _ in range(20):
        real, zeros = perturbed(machine, 1e-5, random)
        coordinates = [
            np.abs(getattr(real, name) - getattr(machine, name)).max()
            for name in ("rails_m", "platform_points_m", "cart_offsets_m")
        ]
        lengths = np.nanmax(np.abs(np.append(real.lengths_m - machine.lengths_m, zeros)))
        scale = min(EVERYTHING.coordinate_m / max(coordinates), EVERYTHING.length_m / lengths)
        off = replace(
            machine,
            **{
                name: getattr(machine, name) + scale * (getattr(real, name) - getattr(machine, name))
                for name in ("rails_m", "platform_points_m", "cart_offsets_m", "lengths_m")
            },
        )
        drives = random.uniform(-1.0, 1.0, (len(s), 5)) * EVERYTHING.actuator_m
        pose, _ = newton(off, q + drives + np.append(np.zeros(3), scale * zeros), nominal)
        assert (np.linalg.norm(pose[:, :3] - nominal[:, :3], axis=1) <= position).all()
        assert (rotation_angle(nominal, pose) <= angle).all()


def test_intervals_are_narrow_and_end_where_the_path_does(of_drives: PoseError) -> None:
    """Over wide boxes the bound would be coarse."""
    assert of_drives.edges[0] == 0.0
    assert of_drives.edges[-1] == 1.0
    widths = np.diff(of_drives.edges)
    assert (widths > 0.0).all()
    assert widths.max() <= WIDEST * (1.0 + 1e-12)


def test_drives_that_do_not_move_the_tool_much_leave_little_error(line: Path, of_drives: PoseError) -> None:
    """One drive alone is off by its amplification, to first order; so are all, by at most the sum."""
    gains = of_drives.amplification.position
    assert (of_drives.position_m <= 1.02e-4 * gains.sum(axis=1)).all()
    assert (of_drives.position_m >= 0.98e-4 * gains.max(axis=1)).all()


def test_errors_beyond_what_is_proven_are_refused(line: Path) -> None:
    """With the place, and with what to do."""
    with pytest.raises(NoSolutionError, match="not proven beyond s = ") as refused:
        bound_pose_error(line, replace(CERTAIN, actuator_m=(0.2,) * 5))
    assert "--following" in refused.value.advice
