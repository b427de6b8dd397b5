"""What splines have to be: continuous functions on [0, 1], cut where boxes end."""

import numpy as np
import pytest
from scipy.interpolate import BSpline

from pipeline.certify.recheck.claims.splines import spline_claim
from pipeline.refine import Path
from tests.certify.paths import knotted, torn


@pytest.mark.parametrize(("degree", "multiplicity"), [(1, 1), (3, 2), (5, 1), (5, 5)])
def test_knots_up_to_the_degree_are_no_jumps(degree: int, multiplicity: int) -> None:
    """Whatever the coefficients are."""
    spline = knotted(degree, multiplicity)
    coefficients = spline.c + np.random.default_rng(1).normal(size=spline.c.shape)
    assert spline_claim(spline).verified
    assert spline_claim(BSpline(spline.t, coefficients, degree)).verified


@pytest.mark.parametrize("by", [0.0, 1e-300, 1e-13, 2.0])
def test_a_jump_of_any_size_is_found(line: Path, by: float) -> None:
    """A knot once more than the degree lets a spline jump; with the same value on both sides it does not."""
    spline = torn(line.spline, 0.0)
    claim = spline_claim(BSpline(spline.t, np.vstack([np.zeros((6, 5)), np.full((6, 5), by)]), 5))
    assert claim.verified == (by == 0.0)
    assert ("jump at s = 0.5" in claim.found) == (by != 0.0)


def test_a_knot_far_too_often_jumps_past_coefficients_of_no_use(line: Path) -> None:
    """Values before and after are the coefficients of the pieces; what lies between them is never reached."""
    spline = torn(line.spline, 0.0)
    t, c = np.insert(spline.t, 6, [0.5] * 2), np.insert(spline.c, 6, [[9.0] * 5] * 2, axis=0)
    assert spline_claim(BSpline(t, c, 5)).verified
    c[8:] += 1e-12
    assert not spline_claim(BSpline(t, c, 5)).verified


@pytest.mark.parametrize("domain", [(0.0, 0.5), (0.0, 1.0 + 1e-15), (-1.0, 1.0), (1e-300, 1.0)])
def test_other_domains_are_found(line: Path, domain: tuple[float, float]) -> None:
    """Exactly zero to one, to the last bit."""
    first, last = domain
    spline = line.spline
    assert spline_claim(spline).verified
    knots = np.where(spline.t == 0.0, first, np.where(spline.t == 1.0, last, np.clip(spline.t, 0.1, 0.4)))
    assert not spline_claim(BSpline(knots, spline.c, 5)).verified


def test_unclamped_splines_are_taken_at_their_domain(line: Path) -> None:
    """Knots beyond the ends of the domain are nothing bad."""
    knots = np.arange(-5.0, 10.0) / 4.0
    coefficients = np.tile(line.q(0.5), (len(knots) - 6, 1))
    assert spline_claim(BSpline(knots[:15], coefficients, 5)).verified


def test_coefficients_have_to_be_numbers_of_five_actuators(line: Path) -> None:
    """Neither four columns, nor what is no number."""
    spline = line.spline
    assert not spline_claim(BSpline(spline.t, spline.c[:, :4], 5)).verified
    broken = BSpline(spline.t, spline.c.copy(), 5)
    broken.c[3, 2] = np.nan
    assert not spline_claim(broken).verified
