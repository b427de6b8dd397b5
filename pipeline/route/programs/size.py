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

    @property
    def built_bytes(self) -> float:
        """Memory while the program is built, as measured."""
        return 80.0 * self.entries

    @property
    def solved_bytes(self) -> float:
        """Memory while the solver prepares and solves it, as measured."""
        return 150.0 * self.entries + 250.0 * (self.rows + self.columns)
