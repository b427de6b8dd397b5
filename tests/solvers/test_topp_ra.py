"""Running TOPP-RA: a known fastest profile, what failure looks like, silence, and Ctrl-C."""

import logging
import signal

import numpy as np
import pytest

from pipeline.arrays import FloatArray
from pipeline.solvers.topp_ra import fastest_profile

S = np.linspace(0.0, 1.0, 201)


def _rows(b: float = 0.0) -> tuple[FloatArray, FloatArray, FloatArray]:
    """|sdd + b sd^2| <= 1 all along the path."""
    a = np.tile([1.0, -1.0], (len(S), 1))
    return a, b * a, np.zeros_like(a)


@pytest.mark.parametrize("cap", [np.inf, 0.5])
def test_bang_bang_or_trapezoid(cap: float) -> None:
    """With |sdd| <= 1 from rest to rest, sd^2 is 2 s, then 2 (1 - s), or the cap if that is less."""
    profile = fastest_profile(S, _rows(), np.full(len(S), cap))
    expected = np.minimum(np.sqrt(2.0 * np.minimum(S, 1.0 - S)), cap)
    assert profile.sd == pytest.approx(expected, abs=1e-4)
    assert profile.controllable.shape == (len(S), 2)
    assert profile.messages == ()


def test_failure_is_nan_with_messages_and_nothing_is_printed(capfd, caplog) -> None:
    """Rows that no motion keeps: no speeds, what toppra says of it, and its logger as it was."""
    a, b, c = _rows()
    c = np.where(np.abs(S - 0.5)[:, None] < 0.05, 2.0, c)
    logger = logging.getLogger("toppra")
    before = (logger.level, logger.propagate, list(logger.handlers))
    profile = fastest_profile(S, (a, b, c), np.full(len(S), np.inf))
    assert np.isnan(profile.sd).all()
    assert np.isnan(profile.controllable).any()
    assert profile.messages
    assert capfd.readouterr() == ("", "")
    assert not caplog.records
    assert (logger.level, logger.propagate, list(logger.handlers)) == before


def test_an_interrupt_is_raised_when_the_solver_is_done() -> None:
    """Ctrl-C does not end up as a failed plan."""

    class Interrupting(np.ndarray):
        """Rows that interrupt when they are first used."""

        def __array_finalize__(self, obj: object) -> None:
            if isinstance(obj, Interrupting):
                signal.raise_signal(signal.SIGINT)

    a, b, c = _rows()
    with pytest.raises(KeyboardInterrupt):
        fastest_profile(S, (a.view(Interrupting), b, c), np.full(len(S), np.inf))
