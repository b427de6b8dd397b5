"""Key figures in words."""

from pipeline.summary.figures import figures_section, figures_words
from pipeline.summary.regions import regions_words


def test_key_figures() -> None:
    """Figures and regions are counted, with thousands separated."""
    assert figures_words(figures_section(4)) == "4 figures"
    assert regions_words({"count": 1234, "gates": 5}) == "1,234 regions, 5 of them gates"
