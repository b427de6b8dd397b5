"""The figures in the summary."""

from pipeline.summary.section import Section


def figures_section(count: int) -> Section:
    """Give the number of figures drawn."""
    return {"status": "done", "count": count}


def figures_words(section: Section) -> str:
    """Say the key figures in words."""
    return f"{section['count']} figures"
