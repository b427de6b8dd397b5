"""The regions in the summary."""

from typing import TYPE_CHECKING

from pipeline.config import Config
from pipeline.summary.section import Section

if TYPE_CHECKING:
    from pipeline.route.regions.table import RegionTable

_OTHER_VARIABLES = 13
"""Variables per step of the paper's model, in addition to one binary for each region."""


def regions_section(config: Config, table: "RegionTable") -> Section:
    """Give the size of stage one; `nominal_variables` is the size of the paper's own model, (13 + count) N."""
    return {
        "status": "done",
        "count": len(table),
        "gates": table.gate_count,
        "nominal_variables": (_OTHER_VARIABLES + len(table)) * config.route.step_budget,
    }


def regions_words(section: Section) -> str:
    """Say the key figures in words."""
    return f"{section['count']:,} regions, {section['gates']:,} of them gates"
