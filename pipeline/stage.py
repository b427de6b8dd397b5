"""The stages of a run and their order."""

from enum import StrEnum


class Stage(StrEnum):
    """A stage of a run, in order."""

    REGIONS = "regions"
    ROUTE = "route"
    REFINE = "refine"
    CERTIFY = "certify"
    RETIME = "retime"
    FIGURES = "figures"

    @property
    def later(self) -> tuple["Stage", ...]:
        """The stages after this one."""
        return STAGES[STAGES.index(self) + 1 :]

    @property
    def earlier(self) -> tuple["Stage", ...]:
        """The stages before this one."""
        return STAGES[: STAGES.index(self)]


STAGES = tuple(Stage)
