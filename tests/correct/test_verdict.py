"""Which motion is better: one that is proven, then one that is off by less."""

from dataclasses import replace

import numpy as np
import pytest

from pipeline.correct import Motion, judge, measure_motion
from pipeline.correct.verdict import largest_distance

CORRECTED = Motion(True, 4e-4, 4e-4, 29.9, 30.1, 6.5)
AGAIN = Motion(True, 0.0, 0.012, 30.2, 30.4, 6.4)


@pytest.mark.parametrize(
    ("corrected", "again", "better"),
    [
        (CORRECTED, AGAIN, "plan again"),
        (CORRECTED, replace(AGAIN, certified=False), "correct"),
        (replace(CORRECTED, certified=False), AGAIN, "plan again"),
        (None, AGAIN, "plan again"),
        (CORRECTED, None, "correct"),
        (replace(CORRECTED, left_m=0.0), AGAIN, "correct"),
    ],
)
def test_proven_comes_first_then_what_is_left(corrected: Motion | None, again: Motion | None, better: str) -> None:
    """A proven motion beats one that is not; of two, the one that is nearer to where it should be."""
    assert judge(corrected, again).better == better


def test_reasons_name_what_was_measured() -> None:
    """Errors, durations and how far both are from the first way are told with their numbers."""
    reasons = " ".join(judge(CORRECTED, AGAIN).reasons)
    assert all(number in reasons for number in ("0.000 mm", "0.400 mm", "6.400 s", "6.500 s", "12.0 mm"))


def test_a_motion_is_read_from_the_summary_of_its_run() -> None:
    """What was not proven is not certified."""
    summary = {"path": {"kappa_max": 29.9}, "trajectory": {"duration_s": 6.5}}
    proven = {**summary, "certificate": {"verdict": "certified", "kappa_bound": 30.1}}
    assert measure_motion(proven, 4e-4, 4e-4) == CORRECTED
    assert not measure_motion({**summary, "certificate": {"verdict": "skipped"}}, 0.0, 0.0).certified


def test_the_distance_from_a_way_is_that_of_its_nearest_place() -> None:
    """Where along the way it is does not matter."""
    way = np.column_stack([np.linspace(0.0, 1.0, 101), np.zeros(101), np.zeros(101)])
    assert largest_distance(np.array([[0.9, 0.003, 0.0], [0.1, 0.0, 0.004]]), way) == pytest.approx(0.004)
