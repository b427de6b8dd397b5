"""Figures as files."""

from matplotlib.figure import Figure

from pipeline.artifacts.results.figures import figure_files


def test_figures_are_pictures() -> None:
    """Every figure becomes a PNG and, on request, a PDF of its own name, the same bytes every time."""
    files = figure_files({"kappa": Figure((1, 1))}, pdf=True)
    assert list(files) == ["figures/kappa.png", "figures/kappa.pdf"]
    assert files["figures/kappa.png"].startswith(b"\x89PNG")
    assert files["figures/kappa.pdf"].startswith(b"%PDF")
    assert figure_files({"kappa": Figure((1, 1))}, pdf=True) == files
    assert figure_files({"kappa": Figure((1, 1))}) == {"figures/kappa.png": files["figures/kappa.png"]}
