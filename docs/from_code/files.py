"""Columns and figures of a run, as the tables in the program list them, and the benchmarks that are kept in git."""

from pathlib import Path

from from_code.markdown import literal, plain, table
from pipeline.export.trajectory_columns import TRAJECTORY_COLUMNS
from pipeline.figures.run_figures import FIGURES


def trajectory_columns() -> str:
    """List the columns of `trajectory.csv`."""
    rows = [(literal(one.name), plain(one.unit), plain(one.meaning)) for one in TRAJECTORY_COLUMNS]
    return table(("column", "unit", "meaning"), rows)


def figure_list() -> str:
    """List the figures of a run with the first sentence of what draws them."""
    rows = []
    for one in FIGURES:
        about = " ".join((one.draw.__doc__ or "").split("\n\n")[0].split())
        rows.append((literal(one.name), plain(about)))
    return table(("figure", "what it shows"), rows)


def benchmark_pages() -> str:
    """Include what every benchmark measured last, in the order of their names."""
    pages = sorted((Path(__file__).parents[2] / "results" / "benchmarks").glob("*.md"))
    return "\n".join(
        f"```{{include}} ../../results/benchmarks/{page.name}\n:heading-offset: 1\n:relative-images:\n```\n"
        for page in pages
    )
