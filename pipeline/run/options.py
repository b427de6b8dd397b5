"""The options of a run."""

from dataclasses import dataclass

from pipeline.config.choices import Proof
from pipeline.stage import STAGES, Stage


@dataclass(frozen=True)
class RunOptions:
    """What a run does beyond what the configuration says.

    Attributes
    ----------
    first : Stage or None
        This stage and later ones run in any case; earlier results must exist and be up to date.
    last : Stage
        The stage to stop after.
    force : bool
        All stages run, also those that are up to date.
    verbose : bool
        Solvers write their logs to the terminal.
    why_not : bool
        If no route exists, find out what prevents it; it is added to the error.
    unproven : bool
        The run goes on with a route that is not proven optimal, instead of stopping there.
    proof : Proof or None
        What is proven, whatever `certify.what` says; None: what it says.
    """

    first: Stage | None = None
    last: Stage = STAGES[-1]
    force: bool = False
    verbose: bool = False
    why_not: bool = True
    unproven: bool = False
    proof: Proof | None = None

    @property
    def forced(self) -> tuple[Stage, ...]:
        """The stages that run even if they are up to date."""
        if self.first is not None:
            return (self.first, *self.first.later)
        return STAGES if self.force else ()
