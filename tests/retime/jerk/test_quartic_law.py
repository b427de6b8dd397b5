"""Quartic pieces: the state within them, splitting, and the time law made of them."""

import numpy as np
import pytest

from pipeline.retime.jerk.quartic_law import QuarticLaw, halved


@pytest.fixture
def law() -> QuarticLaw:
    """Pieces of a smooth law, joined as they have to be."""
    h = np.array([0.2, 0.3, 0.1])
    j = np.array([0.0, 2.0, -3.0, 1.0])
    s, v, w = [0.0], [0.5], [0.0]
    for k, step in enumerate(h):
        rise = (j[k + 1] - j[k]) / step
        s.append(s[-1] + v[-1] * step + w[-1] * step**2 / 2 + j[k] * step**3 / 6 + rise * step**4 / 24)
        v_next = v[-1] + w[-1] * step + j[k] * step**2 / 2 + rise * step**3 / 6
        w.append(w[-1] + j[k] * step + rise * step**2 / 2)
        v.append(v_next)
    return QuarticLaw(np.array(s), np.array(v), np.array(w), j, h)


def test_the_state_is_that_of_the_time_law(law: QuarticLaw) -> None:
    """Path parameter and its derivatives anywhere in a piece, by formula and by the polynomial."""
    time_law = law.time_law()
    piece, part = np.array([0, 1, 1, 2]), np.array([0.0, 0.3, 0.9, 0.5])
    t = time_law.x[piece] + part * law.h[piece]
    for order, value in enumerate(law.state(piece, part)):
        assert value == pytest.approx(time_law(t, nu=order))


def test_the_time_law_has_continuous_jerk(law: QuarticLaw) -> None:
    """Up to the third derivative nothing jumps between pieces."""
    time_law = law.time_law()
    for order in range(4):
        before, after = time_law(time_law.x[1:-1] - 1e-11, nu=order), time_law(time_law.x[1:-1], nu=order)
        assert before == pytest.approx(after, abs=1e-8)


def test_halving_changes_nothing(law: QuarticLaw) -> None:
    """The law is the same with more breakpoints, and only the pieces asked for are split."""
    finer = halved(law, np.array([True, False, True]))
    assert finer.h == pytest.approx([0.1, 0.1, 0.3, 0.05, 0.05])
    t = np.linspace(0.0, 0.6, 50)
    for order in range(4):
        assert finer.time_law()(t, nu=order) == pytest.approx(law.time_law()(t, nu=order), abs=1e-9)
