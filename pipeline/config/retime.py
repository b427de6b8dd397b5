"""Stage three: the path in time."""

from pydantic import Field

from pipeline.config.section import Section


class RetimeConfig(Section):
    """Stage three: the path in time."""

    grid_points: int = Field(
        1_000,
        ge=50,
        le=20_000,
        description="points of the first TOPP-RA grid; doubled while limits are broken between them",
    )
    period_s: float = Field(0.01, ge=0.000_125, le=0.1, description="sampling period of trajectory.csv")
