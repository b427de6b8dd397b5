"""Options of the bound of all paths."""

from pydantic import Field

from pipeline.config.section import Section


class BoundConfig(Section):
    """What no path can do, proven beside the certificate of the one found; no other result depends on it."""

    boxes: int = Field(
        0,
        ge=0,
        le=100_000_000,
        description="boxes to prove how large kappa is on every path, 10,000 a second at best; 0: not asked for",
    )
