"""The proven following errors over s."""

import numpy as np
from matplotlib.patches import StepPatch

from pipeline.certify.following.steps import FollowingProfile
from pipeline.figures.proven.following import following_figure


def test_a_stair_per_claim_in_millimetres() -> None:
    """The values are those of the profile; a claim that was not proven is not drawn."""
    s = np.array([0.0, 0.4, 1.0])
    both = following_figure(FollowingProfile(s, np.array([1e-3, 2e-3]), np.array([3e-3, 4e-3])))
    stairs = [patch for patch in both.axes[0].patches if isinstance(patch, StepPatch)]
    assert [patch.get_data().values.tolist() for patch in stairs] == [[3.0, 4.0], [1.0, 2.0]]
    np.testing.assert_array_equal(stairs[0].get_data().edges, s)
    assert both.axes[0].get_ylim()[0] == 0.0
    one = following_figure(FollowingProfile(s, np.full(2, np.nan), np.array([3e-3, 4e-3])))
    assert len(one.axes[0].patches) == 1


def test_what_stopped_the_searches_is_marked_at_its_s() -> None:
    """A line each, with the name of the limit beside it."""
    s, steps = np.array([0.0, 0.4, 1.0]), np.array([1e-3, 2e-3])
    axes = following_figure(FollowingProfile(s, steps, 2.0 * steps, (("kappa", 0.3), ("regularity", 0.7)))).axes[0]
    assert [line.get_xdata()[0] for line in axes.lines] == [0.3, 0.7]
    assert [text.get_text() for text in axes.texts] == ["kappa", "regularity"]
