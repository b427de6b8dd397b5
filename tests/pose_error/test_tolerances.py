"""The errors of drives that an accuracy asks for: as large as possible, and never larger than proven."""

import numpy as np
import pytest

from pipeline.errors import NoSolutionError
from pipeline.inclusion.uncertainty import CERTAIN, Uncertainty, of_lengths
from pipeline.machine.geometry import ACTUATORS
from pipeline.pose_error import find_drive_tolerances
from pipeline.pose_error.tolerances import COMMON, EQUAL_SHARES

GAINS = np.array([1.0, 2.0, 2.0, 4.0, 5.0])


def bent(uncertainty: Uncertainty) -> float:
    """Bound the error of a tool: nearly linear in the drives' errors, beside three times that of the lengths."""
    linear = float(GAINS @ uncertainty.actuator_m)
    return 3.0 * uncertainty.length_m + linear + 20.0 * linear**2


@pytest.mark.parametrize("geometry", [CERTAIN, of_lengths(1e-4)])
@pytest.mark.parametrize("accuracy_m", [5e-4, 1e-2])
def test_what_is_found_keeps_the_accuracy_and_uses_it(geometry: Uncertainty, accuracy_m: float) -> None:
    """The bound is within it, and not by more than a hundredth."""
    found = find_drive_tolerances(bent, GAINS, geometry, accuracy_m)
    assert list(found) == [COMMON, EQUAL_SHARES, *ACTUATORS]
    for one in found.values():
        errors = Uncertainty(geometry.length_m, actuator_m=tuple(one.errors_m.tolist()))
        assert one.bound_m == pytest.approx(bent(errors), rel=1e-12)
        assert 0.99 * accuracy_m <= one.bound_m <= accuracy_m


def test_the_kinds_are_what_they_are_called() -> None:
    """All alike; equal shares of the error; one alone."""
    found = find_drive_tolerances(bent, GAINS, CERTAIN, 1e-3)
    assert np.ptp(found[COMMON].errors_m) == 0.0
    np.testing.assert_allclose(found[EQUAL_SHARES].errors_m * GAINS, found[EQUAL_SHARES].errors_m[0], rtol=1e-12)
    for k, name in enumerate(ACTUATORS):
        assert np.flatnonzero(found[name].errors_m).tolist() == [k]


def test_a_geometry_that_takes_all_of_the_accuracy_is_refused() -> None:
    """By how much, and what to change."""
    with pytest.raises(NoSolutionError, match=r"geometry alone put the tool up to 0\.3 mm off") as refused:
        find_drive_tolerances(bent, GAINS, of_lengths(1e-4), 2e-4)
    assert "--accuracy-mm" in refused.value.advice


def test_errors_that_are_not_proven_are_not_found() -> None:
    """Where the proof ends before the accuracy is used up, the largest proven errors are taken."""

    def proven_to_a_third(uncertainty: Uncertainty) -> float:
        if (bound := bent(uncertainty)) > 1e-3:
            raise NoSolutionError("pose error", "not proven", "smaller errors")
        return bound

    found = find_drive_tolerances(proven_to_a_third, GAINS, CERTAIN, 3e-3)
    assert all(3e-4 <= one.bound_m <= 1e-3 for one in found.values())


def test_where_nothing_is_proven_the_reason_is_that_of_the_proof() -> None:
    """Of the smallest errors that were tried."""

    def unproven(uncertainty: Uncertainty) -> float:
        raise NoSolutionError("pose error", "for errors of this size", "smaller errors")

    with pytest.raises(NoSolutionError, match="for errors of this size"):
        find_drive_tolerances(unproven, GAINS, CERTAIN, 1e-3)
