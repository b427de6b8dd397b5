"""How runs ended, in words that many of them have in common."""

import pytest

from pipeline.errors import ConfigError, ConfigIssue, InfeasibleError, NoSolutionError, PipelineError, UsageError
from pipeline.stage import Stage
from pipeline.study.rows import Ending, Row, why


@pytest.mark.parametrize(
    ("error", "ending", "reason"),
    [
        (InfeasibleError("route", "", ""), Ending.NO_SOLUTION, "no route"),
        (NoSolutionError("route", "", "", {"status": "not proven optimal"}), Ending.NO_SOLUTION, "route not proven"),
        (NoSolutionError("route", "", ""), Ending.NO_SOLUTION, "no route found"),
        (NoSolutionError("certify", "", ""), Ending.NO_SOLUTION, "not certified"),
        (NoSolutionError("simulate", "", ""), Ending.NO_SOLUTION, "the twin does not arrive"),
        (ConfigError([ConfigIssue("task", "no")]), Ending.REFUSED, "not possible as configured"),
        (UsageError("no"), Ending.ERROR, "UsageError"),
    ],
)
def test_errors_are_sorted(error: PipelineError, ending: Ending, reason: str) -> None:
    """By how the run ended, and why."""
    assert why(error) == (ending, reason)


def test_every_stage_has_its_words() -> None:
    """No stage fails without a reason."""
    assert all(why(NoSolutionError(stage, "", ""))[1] for stage in Stage)


def test_only_a_time_limit_depends_on_the_time_limit() -> None:
    """All other endings are final."""
    assert not Row("a", Ending.TIME_LIMIT, time_limit_s=5.0).is_final(6.0)
    assert Row("a", Ending.TIME_LIMIT, time_limit_s=5.0).is_final(5.0)
    assert all(Row("a", ending).is_final(6.0) for ending in Ending if ending is not Ending.TIME_LIMIT)
