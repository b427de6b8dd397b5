"""The row of a run: how it ended, why, and its figures."""

from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from enum import StrEnum
from typing import Any, Self

from pipeline.errors import ConfigError, InfeasibleError, NoSolutionError, PipelineError, UnfitConfigError
from pipeline.stage import Stage


class Ending(StrEnum):
    """How a run ended."""

    DONE = "done"
    NO_SOLUTION = "no solution"
    REFUSED = "refused"
    TIME_LIMIT = "time limit"
    KILLED = "killed its worker"
    ERROR = "error"


_UNSURE = (Ending.TIME_LIMIT, Ending.KILLED, Ending.ERROR)

_WITHOUT = {
    Stage.REGIONS: "no regions",
    Stage.ROUTE: "no route found",
    Stage.REFINE: "no path",
    Stage.CERTIFY: "not certified",
    Stage.RETIME: "no motion",
    Stage.FIGURES: "no figures",
}
_NO_ROUTE = "no route"
_UNPROVEN = "route not proven"
_REFUSED = "not possible as configured"
_LOST = "the twin does not arrive"


@dataclass(frozen=True)
class Row:
    """What is kept of a run beside its folder.

    Attributes
    ----------
    key : str
        The key of its case.
    ending : str
        How it ended: a value of `Ending`.
    reason, message : str
        Why, in two or three words that many runs have in common, and in full; empty if it is done.
    figures : dict
        Numbers, words and truth values of its `summary.json`, by their paths.
    seconds : float
        How long it took.
    time_limit_s : float
        The time it was given.
    program : str
        The program that ran it.
    """

    key: str
    ending: str
    reason: str = ""
    message: str = ""
    figures: dict[str, Any] = field(default_factory=dict)
    seconds: float = 0.0
    time_limit_s: float = 0.0
    program: str = ""

    @classmethod
    def read(cls, data: Mapping[str, Any]) -> Self:
        """Take a row from plain data; raises TypeError for other data than that of a row."""
        return cls(**data)

    def data(self) -> dict[str, Any]:
        """Put the row into plain data."""
        return asdict(self)

    @property
    def is_unsure(self) -> bool:
        """Whether another attempt may end otherwise, given more time, memory, or luck."""
        return self.ending in _UNSURE

    def is_final(self, time_limit_s: float) -> bool:
        """Check whether the run need not be run again: it ended by itself, or had the same time."""
        return self.ending != Ending.TIME_LIMIT or self.time_limit_s == time_limit_s


def why(error: PipelineError) -> tuple[Ending, str]:
    """Sort an error: how the run ended, and the reason in few words."""
    if isinstance(error, NoSolutionError) and not isinstance(error, UnfitConfigError):
        return Ending.NO_SOLUTION, _reason(error)
    if isinstance(error, ConfigError | UnfitConfigError):
        return Ending.REFUSED, _REFUSED
    return Ending.ERROR, type(error).__name__


def _reason(error: NoSolutionError) -> str:
    if error.stage not in tuple(Stage):
        return _LOST
    stage = Stage(error.stage)
    if stage is Stage.ROUTE and isinstance(error, InfeasibleError):
        return _NO_ROUTE
    if stage is Stage.ROUTE and error.diagnosis.get("status") == "not proven optimal":
        return _UNPROVEN
    return _WITHOUT[stage]
