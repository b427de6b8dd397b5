"""The proven bound of kappa beside kappa itself."""

from collections.abc import Callable
from itertools import pairwise

import numpy as np
import pytest
from matplotlib.figure import Figure
from matplotlib.patches import StepPatch

from pipeline.certify.recheck import KappaProfile
from pipeline.config import Config
from pipeline.figures.proven.proof import boxes_of, proof_figure
from pipeline.refine.measure import PathSamples
from pipeline.route.metric import arc_length, step_sizes


@pytest.fixture(scope="module")
def profile(refined: PathSamples) -> KappaProfile:
    """Bound kappa over five boxes, each by a tenth more than the largest sample."""
    edges = np.array([0.0, 0.1, 0.3, 0.6, 0.8, 1.0])
    inside = [(refined.s >= a) & (refined.s <= b) for a, b in pairwise(edges)]
    return KappaProfile(edges, np.array([1.1 * refined.kappa[rows].max() for rows in inside]))


@pytest.fixture(scope="module")
def figure(agder_config: Config, refined: PathSamples, profile: KappaProfile) -> Figure:
    """Draw the bounds."""
    return proof_figure(agder_config, refined, profile)


def test_a_stair_per_box_above_the_curve(
    figure: Figure, agder_config: Config, refined: PathSamples, profile: KappaProfile
) -> None:
    """Stairs have the bounds and reach over the length of their boxes; the curve is the samples."""
    top = figure.axes[0]
    (stairs,) = [patch for patch in top.patches if isinstance(patch, StepPatch)]
    values, edges, _ = stairs.get_data()
    np.testing.assert_array_equal(values, profile.kappa)
    length = arc_length(refined.pose, step_sizes(agder_config.route))
    np.testing.assert_allclose(edges, np.interp(profile.edges, refined.s, length))
    np.testing.assert_array_equal(top.get_lines()[0].get_ydata(), refined.kappa)
    assert top.get_ylim()[1] > profile.kappa.max()


def test_the_excess_is_above_zero(figure: Figure) -> None:
    """Each sample is below the bound of its own box, here by ten per cent at least."""
    excess = np.asarray(figure.axes[1].get_lines()[0].get_ydata())
    assert (excess > 10.0 - 1e-9).all()
    assert figure.axes[1].get_ylim()[0] == 0.0


def test_boxes_hold_their_samples(profile: KappaProfile) -> None:
    """Every s is in the box around it, both ends included."""
    np.testing.assert_array_equal(boxes_of(profile, np.array([0.0, 0.1, 0.2, 0.9, 1.0])), [0, 1, 1, 4, 4])


def test_axes_have_units(figure: Figure, assert_laid_out: Callable[[Figure], None]) -> None:
    """Moments in metres, per cent, steps; nothing covers anything."""
    assert [axes.get_ylabel() for axes in figure.axes] == ["κ (moments in m)", "bound above\nsampled κ (%)"]
    assert figure.axes[1].get_xlabel() == "length along the path (steps)"
    assert_laid_out(figure)
