"""What is driven between the rows of an export."""

from dataclasses import dataclass

import numpy as np
import pytest

from pipeline.export.deviation import quintic_deviation
from pipeline.retime import TrajectorySamples


@dataclass(frozen=True)
class Swinging:
    """A motion whose every derivative is known: sines of five frequencies."""

    rates: tuple[float, ...] = (0.0, 1.0, 2.0, 4.0, 8.0)

    def q(self, t: np.ndarray, derivative: int = 0) -> np.ndarray:
        """Evaluate a derivative (n, 5)."""
        w = np.array(self.rates)
        return w**derivative * np.sin(np.multiply.outer(t, w) + derivative * np.pi / 2.0)

    def sampled(self, period_s: float) -> TrajectorySamples:
        """Sample two seconds."""
        t = period_s * np.arange(round(2.0 / period_s) + 1)
        none = np.zeros((len(t), 6))
        return TrajectorySamples(period_s, t, self.q(t), self.q(t, 1), self.q(t, 2), none, none[:, 0])


def test_it_is_the_remainder_of_the_polynomials() -> None:
    """Of order six: w^6 (h / 2)^6 / 720 in the middle of a period; nothing for what stands still."""
    found = {period: quintic_deviation(Swinging(), Swinging().sampled(period)) for period in (0.1, 0.05)}
    assert found[0.1][0] == 0.0
    for period, off in found.items():
        expected = (np.array(Swinging().rates) * period / 2.0) ** 6 / 720.0
        np.testing.assert_allclose(off[2:], 1.1 * expected[2:], rtol=0.05)
    assert found[0.1][4] / found[0.05][4] == pytest.approx(64.0, rel=0.05)
