"""Stage three: the path in time."""

from typing import Annotated

from pydantic import Field

from pipeline.config.section import Section

Wait = Annotated[float, Field(ge=0.0, le=3_600.0)]


class RetimeConfig(Section):
    """Stage three: the path in time."""

    grid_points: int = Field(
        1_000,
        ge=50,
        le=20_000,
        description="points of the first TOPP-RA grid; doubled while limits are broken or time is lost between them",
    )
    period_s: float = Field(0.01, ge=0.000_125, le=0.1, description="sampling period of trajectory.csv")
    jerk: bool = Field(
        True, description="on: limit jerk, too, with zero acceleration at both ends; off: accelerations jump"
    )
    jerk_pieces: int = Field(
        300,
        ge=40,
        le=5_000,
        description="pieces of the law with limited jerk, at first; more where acceleration changes quickly",
    )
    bound_points: int = Field(
        1_000, ge=50, le=50_000, description="grid of the lower bound on the duration; the finer, the nearer it comes"
    )
    speed: float = Field(1.0, ge=1e-6, le=1.0, description="part of the full speed: 0.3 takes 1 / 0.3 times as long")
    dwell_s: tuple[Wait, Wait] = Field(
        (0.0, 0.0), description="[at the start, at the goal]: waited before and after the motion, whole periods"
    )
