"""Options of the figures."""

from pydantic import Field

from pipeline.config.section import Section


class FiguresConfig(Section):
    """How results are drawn; no other result depends on it."""

    pdf: bool = Field(False, description="figures also as PDF, for print; always drawn as PNG")
