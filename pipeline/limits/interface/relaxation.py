"""How far a limit would have to give for a route to exist: milder values, and the regions each of them admits."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Self

import numpy as np

from pipeline.arrays import BoolArray, FloatArray
from pipeline.config import Config
from pipeline.machine.samples import PoseSamples

RegionFilter = Callable[[float], tuple[FloatArray, BoolArray]]
"""For a value of the limit: the x windows (n, 2) of n regions, and which regions the value admits (n,)."""

Obstruction = Callable[[PoseSamples], str]


def _unknown(samples: PoseSamples) -> str:
    return ""


@dataclass(frozen=True, eq=False)
class Relaxation:
    """A limit that may prevent a route, and milder values of it.

    A region table built with the mildest value holds the regions of all others, so that one table and its moves serve
    a whole bisection.

    Attributes
    ----------
    key : str
        Its path in the configuration.
    configured : float
        Its value there.
    levels : (n,)
        A value known not to suffice, then values to try, each milder than the one before.
    segments : tuple of int
        Ends of the parts of `levels` that are tried one after the other, each with a table of its own.
    change : callable
        Returns the configuration with a value.
    prepare : callable
        Returns the filter of the regions of a wide table: their poses and x windows (n, 2).
    locked_axes : tuple of str or None
        Tilt axes that stay locked, if the change is to unlock others.
    removes : bool
        That the change is to remove it, and nothing lies between.
    part_of : str
        Key of the relaxation that removes this and others like it: if that does not help, this does not.
    obstruction : callable
        Says how what is removed would be in the way of a motion, from poses along it; empty if nothing can be said.
    """

    key: str
    configured: float
    levels: FloatArray
    segments: tuple[int, ...]
    change: Callable[[float], Config]
    prepare: Callable[[PoseSamples, FloatArray], RegionFilter]
    locked_axes: tuple[str, ...] | None = None
    removes: bool = False
    part_of: str = ""
    obstruction: Obstruction = _unknown

    @classmethod
    def removal(cls, key: str, without: Config, part_of: str = "", obstruction: Obstruction = _unknown) -> Self:
        """Remove something that the task asks for; `without` is the configuration without it."""
        return cls(
            key=key,
            configured=0.0,
            levels=np.array([0.0, 1.0]),
            segments=(2,),
            change=lambda value: without,
            prepare=lambda samples, windows_m: lambda value: (windows_m, np.ones(len(windows_m), dtype=bool)),
            removes=True,
            part_of=part_of,
            obstruction=obstruction,
        )

    @classmethod
    def of_one_table(
        cls,
        key: str,
        configured: float,
        milder: FloatArray,
        change: Callable[[float], Config],
        prepare: Callable[[PoseSamples, FloatArray], RegionFilter],
    ) -> Self:
        """Try values (n,) milder than the configured one, all on the table of the mildest."""
        levels = np.array([configured, *milder])
        return cls(key, configured, levels, (len(levels),), change, prepare)


def threshold_filter(needed: FloatArray, windows_m: FloatArray, at_most: bool = True) -> RegionFilter:
    """Admit the regions whose needed value (n,) is at most the limit's value, or at least it; windows stay."""
    return lambda value: (windows_m, needed <= value if at_most else needed >= value)


def removals(config: Config, key: str) -> list[Relaxation]:
    """Remove the entries of a list of the task, `task.<key>`: all of them, and each one alone."""
    entries = getattr(config.task, key)
    whole = f"task.{key}" if len(entries) > 1 else ""
    found = [Relaxation.removal(whole, with_values(config, "task", **{key: ()}))] if whole else []
    for k in range(len(entries)):
        others = entries[:k] + entries[k + 1 :]
        found.append(Relaxation.removal(f"task.{key}[{k}]", with_values(config, "task", **{key: others}), whole))
    return found


def with_values(config: Config, section: str, **values: Any) -> Config:
    """Return the configuration with other values in one section."""
    return config.model_copy(update={section: getattr(config, section).model_copy(update=values)})
