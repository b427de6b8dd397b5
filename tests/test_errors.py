"""What the user gets to read: exit codes, messages, and what to do next."""

import pytest

from pipeline.errors import (
    ConfigError,
    ConfigIssue,
    ForwardKinematicsError,
    NoSolutionError,
    PipelineError,
    UsageError,
)
from pipeline.progress import silent
from pipeline.status import Status


@pytest.mark.parametrize(
    ("error", "code"),
    [
        (ConfigError([ConfigIssue("task", "is missing")]), 2),
        (UsageError("no such stage"), 2),
        (NoSolutionError("route", "no route exists", "allow more tilt"), 1),
        (ForwardKinematicsError(0.1, 3, [0.0] * 6), 1),
    ],
)
def test_errors_carry_their_exit_code(error: PipelineError, code: int):
    """Bad configuration or usage ends with 2, no solution with 1."""
    assert error.exit_code == code


def test_no_solution_says_what_to_change():
    """Stage, reason and advice are in the message, the diagnosis beside it."""
    error = NoSolutionError("route", "no route exists", "Allow more tilt.", {"regions": 10})
    assert str(error) == "route: no route exists\n  What to change: Allow more tilt."
    assert error.diagnosis == {"regions": 10}
    assert NoSolutionError("route", "a", "b").diagnosis == {}


def test_every_status_has_advice():
    """Only optimal and converged results may be used; every other status says what to do."""
    assert {status for status in Status if status.solved} == {Status.OPTIMAL, Status.CONVERGED}
    for status in Status:
        assert status.advice.endswith(".")
        assert status.advice.startswith("Nothing") == status.solved


def test_silent_progress_says_nothing(capsys: pytest.CaptureFixture[str]):
    """The default listener prints nothing."""
    silent("solving", 0.5)
    assert capsys.readouterr() == ("", "")
