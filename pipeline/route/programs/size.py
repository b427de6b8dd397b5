"""The exact size of a program, known without building it."""

from dataclasses import dataclass


@dataclass(frozen=True)
class ProgramSize:
    """Numbers of unknowns, of booleans among them, of rows and of matrix entries.

    Coefficients that happen to be zero count as entries.
    """

    columns: int
    rows: int
    booleans: int
    entries: int
