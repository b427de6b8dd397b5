"""Where a calibration starts, and data that are not what they are taken for."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from pipeline.calibrate.data.poses import StaticPoses
from pipeline.calibrate.estimate.start import start
from pipeline.config import Config
from pipeline.errors import UsageError
from tests.calibrate.conftest import Seen

Wrong = Callable[[StaticPoses], StaticPoses]


@pytest.mark.parametrize(("reflectors", "poses"), [(1, 40), (2, 8), (3, 15)])
def test_frame_and_assemblies_are_found(see: Callable[..., Seen], quick_config: Config, reflectors: int, poses: int):
    """Nothing but encoders and points are given: every pose is the one that was measured."""
    seen = see(reflectors, poses=poses, seed=5)
    model, guess = start(quick_config, seen.configured, seen.simulated.poses)
    np.testing.assert_allclose(guess, seen.guess, atol=1e-7)
    truth = seen.simulated.truth
    np.testing.assert_allclose(model.rotation, truth.rotation, atol=4e-3)
    np.testing.assert_allclose(model.translation_m, truth.translation_m, atol=4e-3)


def _seen(change: Callable[[np.ndarray], np.ndarray]) -> Wrong:
    return lambda poses: replace(poses, seen_m=change(poses.seen_m))


def _shown(change: Callable[[np.ndarray], np.ndarray]) -> Wrong:
    return lambda poses: replace(poses, q_m=change(poses.q_m))


WRONG: tuple[tuple[Wrong, str], ...] = (
    (_seen(lambda y: 1e3 * y), "reflectors look like millimetres"),
    (_seen(lambda y: y / 0.0254), "reflectors look like inches"),
    (_shown(lambda q: 1e3 * q), "q1_m to q5_m look like millimetres"),
    (_seen(lambda y: y[:, [1, 2, 0]]), "reflectors are in another order.\n.*take x3_m, x1_m, x2_m"),
    (_seen(lambda y: y * [1.0, 1.0, -1.0]), "tracker's frame is left-handed.\n.*swap two of its axes"),
    (_seen(lambda y: y[:, ::-1, [1, 0, 2]]), "another order and the tracker's frame is left-handed"),
    (_shown(lambda q: q[:, [0, 1, 2, 4, 3]]), "beyond its range"),
    (_shown(lambda q: q[:, [1, 2, 0, 3, 4]]), "cannot be assembled"),
    (_seen(lambda y: y + np.arange(3)[:, None]), "reflectors are measured .* m apart"),
    (_seen(lambda y: y[::-1]), "mm off the configured machine in the median"),
)


@pytest.mark.parametrize(("wrong", "message"), WRONG, ids=[message for _, message in WRONG])
def test_wrong_data_are_told_as_what_they_are(
    see: Callable[..., Seen], quick_config: Config, wrong: Wrong, message: str
):
    """Units, order, handedness and columns are recognised, each with what to change."""
    seen = see(3, poses=40)
    with pytest.raises(UsageError, match=f"(?s){message}") as refused:
        start(quick_config, seen.configured, wrong(seen.simulated.poses))
    assert "What to change" in str(refused.value)


def test_the_advice_for_another_order_is_right(see: Callable[..., Seen], quick_config: Config):
    """Taking the columns that the message names makes the measurement usable."""
    seen = see(3, poses=20)
    poses = replace(seen.simulated.poses, seen_m=seen.simulated.poses.seen_m[:, [1, 2, 0]])
    with pytest.raises(UsageError) as refused:
        start(quick_config, seen.configured, poses)
    columns = str(refused.value).split("take ")[1].split(" (")[0]
    order = [int(name[1]) - 1 for name in columns.split(", ")]
    _, guess = start(quick_config, seen.configured, replace(poses, seen_m=poses.seen_m[:, order]))
    np.testing.assert_allclose(guess, seen.guess, atol=1e-7)


def test_points_on_a_line_do_not_tell_where_the_tracker_stands(see: Callable[..., Seen], quick_config: Config):
    """One pose with two reflectors, however often, leaves a turn about their line."""
    seen = see(2, poses=40)
    with pytest.raises(UsageError, match="of a line"):
        start(quick_config, seen.configured, seen.simulated.poses.at(np.zeros(5, dtype=int)))
