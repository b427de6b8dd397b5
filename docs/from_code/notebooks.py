"""Notebooks as pages: their text and code as they are, without outputs."""

from pathlib import Path

import jupytext

_FOLDER = Path(__file__).parents[2] / "notebooks"


def notebook_page(name: str) -> str:
    """Write the cells of a notebook as Markdown; commands to Jupyter itself are left out."""
    cells = jupytext.read(_FOLDER / f"{name}.py").cells
    return "\n\n".join(
        cell.source.replace(".ipynb)", ".md)") if cell.cell_type == "markdown" else _code(cell.source) for cell in cells
    )


def _code(source: str) -> str:
    lines = [line for line in source.splitlines() if not line.startswith("%")]
    return "\n".join(["```python", *lines, "```"])
