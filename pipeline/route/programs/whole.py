"""The programs over all regions at a time, by the name they have in `route.formulation`.

`core`, the formulation that is solved at full size, is not among them: it solves one program per core.
"""

from collections.abc import Callable
from dataclasses import dataclass

from pipeline.arrays import FloatArray, IntArray
from pipeline.route.bounds.budgets import Budget
from pipeline.route.moves.candidates import Moves
from pipeline.route.programs.compact import build_compact, compact_size, read_compact
from pipeline.route.programs.paper import build_paper, paper_size, read_paper
from pipeline.route.programs.size import ProgramSize
from pipeline.route.regions.table import RegionTable
from pipeline.solvers.highs import LinearProgram

Build = Callable[[RegionTable, Moves, FloatArray, int, tuple[Budget, ...]], LinearProgram]
"""Writes the program: regions, excluded moves, largest moves per step (5,), step budget, budgets."""
Read = Callable[[FloatArray, RegionTable, int], tuple[IntArray, FloatArray]]
"""Reads the region and the x of every step (N,): values of a solution, regions, step budget."""
Size = Callable[[int, int, int, int, tuple[Budget, ...]], ProgramSize]
"""Counts without building: regions, step budget, excluded pairs, regions that have any, budgets."""


@dataclass(frozen=True)
class WholeProgram:
    """A program over all regions: how it is written, how its solution is read, how large it is."""

    build: Build
    read: Read
    size: Size


WHOLE_PROGRAMS = {
    "paper": WholeProgram(build_paper, read_paper, paper_size),
    "compact": WholeProgram(build_compact, read_compact, compact_size),
}
