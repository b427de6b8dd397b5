"""What the user gets to read: exit codes, messages, and what to do next."""

import copy
import importlib
import inspect
import multiprocessing
import pickle
import pkgutil
import typing
from concurrent.futures import ProcessPoolExecutor

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import pipeline
from pipeline.errors import (
    ArgumentError,
    ConfigError,
    ConfigIssue,
    ForwardKinematicsError,
    NoSolutionError,
    PipelineError,
    UsageError,
)
from pipeline.progress import silent
from pipeline.status import Status

PLAIN = st.none() | st.integers() | st.text() | st.lists(st.floats(allow_nan=False))
ISSUES = st.builds(ConfigIssue, st.text(), st.text(), PLAIN)
GIVEN: dict[object, st.SearchStrategy[typing.Any]] = {
    str: st.text(),
    int: st.integers(),
    float: st.floats(allow_nan=False),
    list[float]: st.lists(st.floats(allow_nan=False)),
    list[ConfigIssue]: st.lists(ISSUES),
    dict[str, object] | None: st.none() | st.dictionaries(st.text(), PLAIN),
}
"""What constructors of errors take: an error that takes something else needs a row."""


def _errors_of_the_package() -> list[type[BaseException]]:
    """Import every module, and find every class of exception that one of them defines."""
    found = set()
    for module in pkgutil.walk_packages(pipeline.__path__, "pipeline."):
        if not module.name.endswith("__main__"):
            members = vars(importlib.import_module(module.name)).values()
            found |= {one for one in members if inspect.isclass(one) and issubclass(one, BaseException)}
    return sorted((one for one in found if one.__module__.startswith("pipeline")), key=lambda one: one.__name__)


ERRORS = _errors_of_the_package()


def _arguments(kind: type[BaseException]) -> st.SearchStrategy[tuple[typing.Any, ...]]:
    if inspect.isfunction(kind.__init__):
        hints = typing.get_type_hints(kind.__init__)
        return st.tuples(*[GIVEN[hints[name]] for name in list(inspect.signature(kind).parameters)])
    return st.tuples(st.text())


@pytest.mark.parametrize(
    ("error", "code"),
    [
        (ConfigError([ConfigIssue("task", "is missing")]), 2),
        (UsageError("no such stage"), 2),
        (ArgumentError("s: expected finite numbers, not nan"), 2),
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


def test_all_errors_are_found():
    """Those of users are among them; a module that defines others is walked, too."""
    assert {ArgumentError, ConfigError, UsageError, NoSolutionError, ForwardKinematicsError} <= set(ERRORS)
    assert all(issubclass(kind, PipelineError | KeyboardInterrupt) for kind in ERRORS)


@pytest.mark.parametrize("kind", ERRORS)
@given(data=st.data())
def test_errors_survive_pickling_and_copying(kind: type[BaseException], data: st.DataObject):
    """Of every class, with everything that they carry."""
    error = kind(*data.draw(_arguments(kind)))
    error.add_note("where")
    for other in (pickle.loads(pickle.dumps(error)), copy.copy(error), copy.deepcopy(error)):
        assert type(other) is kind
        assert str(other) == str(error)
        assert other.args == error.args
        assert vars(other) == vars(error)


def test_errors_survive_a_process_pool():
    """The pool takes errors in, hands on what a task raised, and goes on; its processes need no module of tests."""
    diagnosis = {"s": np.float64(0.5), "where": np.arange(3.0)}
    cases = (
        (NoSolutionError, ("certify", "no box", "refine again", diagnosis)),
        (ConfigError, ([ConfigIssue("task.goal", "is missing")], "a.yaml")),
        (ForwardKinematicsError, (0.1, 3, [0.0] * 6)),
    )
    with ProcessPoolExecutor(1, multiprocessing.get_context("spawn")) as pool:
        for kind, arguments in cases:
            with pytest.raises(kind) as caught:
                pool.submit(exec, "raise error", {"error": kind(*arguments)}).result(timeout=60)
            assert str(caught.value) == str(kind(*arguments))
