"""Notebooks: each runs from its first cell to its last, has a reason for every cell, and shows pictures."""

from itertools import pairwise
from pathlib import Path

import jupytext
import pytest
from nbclient import NotebookClient
from nbformat import NotebookNode

FOLDER = Path(__file__).parents[1] / "notebooks"
NOTEBOOKS = sorted(FOLDER.glob("*.py"))
PICTURES = {
    "1_machine_and_singularities": 4,
    "2_route_to_trajectory": 7,
    "3_your_own_machine": 3,
    "4_tracker_to_calibrated_path": 5,
}


def read(file: Path) -> NotebookNode:
    """Read a notebook as it is kept in git: as text."""
    return jupytext.read(file)


def test_they_are_these() -> None:
    """No notebook is left out below."""
    assert [file.stem for file in NOTEBOOKS] == sorted(PICTURES)


@pytest.mark.parametrize("file", NOTEBOOKS, ids=lambda file: file.stem)
def test_every_cell_has_a_reason(file: Path) -> None:
    """Text says why before every cell of code."""
    kinds = [cell.cell_type for cell in read(file).cells]
    assert kinds[0] == "markdown"
    assert all(before == "markdown" for before, kind in pairwise(kinds) if kind == "code")


@pytest.mark.slow
@pytest.mark.parametrize("file", NOTEBOOKS, ids=lambda file: file.stem)
def test_it_runs(file: Path) -> None:
    """All cells run without an error and without a word on stderr, and the pictures are there."""
    notebook = read(file)
    NotebookClient(notebook, timeout=300, resources={"metadata": {"path": FOLDER}}).execute()
    outputs = [output for cell in notebook.cells for output in cell.get("outputs", [])]
    assert sum("image/png" in output.get("data", {}) for output in outputs) == PICTURES[file.stem]
    assert [output.text for output in outputs if output.get("name") == "stderr"] == []
