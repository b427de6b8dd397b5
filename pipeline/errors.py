"""What can go wrong, reported so that a user can act on it; every class has its exit code."""

from dataclasses import dataclass
from typing import Any, Self

_MOST_SHOWN = 20
"""Faults of a configuration that are shown: a file of another kind has thousands."""


class PipelineError(Exception):
    """Base of all errors meant for users; the command line prints them without a traceback.

    Errors of every subclass, whatever its constructor takes, can be pickled and copied: a process pool hands them on.
    """

    exit_code = 1

    def __reduce__(self) -> tuple[Any, ...]:
        return _restore_error, (type(self), self.args, self.__dict__)


def _restore_error(kind: type[PipelineError], args: tuple[Any, ...], attributes: dict[str, Any]) -> PipelineError:
    """Rebuild an error without its constructor, which takes other arguments than the message."""
    error = kind.__new__(kind, *args)
    error.args = args
    error.__dict__.update(attributes)
    return error


@dataclass(frozen=True)
class ConfigIssue:
    """One thing wrong with a configuration: the key's path, the value found there, what is allowed.

    An empty path stands for the file as a whole.
    """

    path: str
    message: str
    value: object = None

    def __str__(self) -> str:
        return f"{self.path}: {self.message}" if self.path else self.message


class ConfigError(PipelineError):
    """The configuration cannot be used; `issues` names every key that has to change."""

    exit_code = 2

    def __init__(self, issues: list[ConfigIssue], source: str = "configuration") -> None:
        self.issues = tuple(issues)
        self.source = source
        rest = len(issues) - _MOST_SHOWN
        more = [f"  and {rest:,} more"] if rest > 0 else []
        shown = [f"  {issue}" for issue in issues[:_MOST_SHOWN]]
        super().__init__("\n".join([f"{source} cannot be used:", *shown, *more]))


class UsageError(PipelineError):
    """A command was given something it cannot use (a missing run folder, an unknown stage)."""

    exit_code = 2


class LockedError(UsageError):
    """Another process is writing to the folder that a command was given."""


class ArgumentError(UsageError, ValueError):
    """A function was given an argument that its docstring excludes: which one, what it is, what is expected."""


class NoSolutionError(PipelineError):
    """A stage ended without a usable result: why, where, and what to change."""

    def __init__(self, stage: str, reason: str, advice: str, diagnosis: dict[str, object] | None = None) -> None:
        self.stage = stage
        self.reason = reason
        self.advice = advice
        self.diagnosis = dict(diagnosis or {})
        super().__init__(f"{stage}: {reason}\n  What to change: {advice}")

    def with_advice(self, advice: str) -> Self:
        """Give the same error with other advice; notes are kept."""
        changed = type(self)(self.stage, self.reason, advice, self.diagnosis)
        for note in getattr(self, "__notes__", []):
            changed.add_note(note)
        return changed


class InfeasibleError(NoSolutionError):
    """A stage has proven that there is no solution."""


class UnfitConfigError(NoSolutionError):
    """A stage found that the configuration cannot be met.

    Old results are superseded, as after every failure; the exit code is that of a bad configuration.
    """

    exit_code = 2


class ForwardKinematicsError(PipelineError):
    """Newton's method found no pose for given actuator positions (too far from the guess, or singular)."""

    def __init__(self, residual_m: float, index: int, pose_guess: list[float]) -> None:
        self.residual_m = residual_m
        self.index = index
        guess = ", ".join(f"{value:.4f}" for value in pose_guess)
        super().__init__(
            f"forward kinematics did not converge for entry {index}: the links still miss their lengths by "
            f"{residual_m:.2e} m, starting from pose ({guess}).\n"
            "  What to change: start from a nearer pose, or keep away from Type-II singularities."
        )
