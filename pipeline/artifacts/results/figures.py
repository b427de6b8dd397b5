"""Figures as files: each as pixels and, on request, as vectors."""

import io
from collections.abc import Mapping
from typing import TYPE_CHECKING

from pipeline.artifacts.layout import figure_names

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def figure_files(figures: Mapping[str, "Figure"], pdf: bool = False) -> dict[str, bytes]:
    """Write every figure under its own name, as pixels and, on request, as vectors (PDF)."""
    files = {}
    for title, figure in figures.items():
        _lay_out(figure)
        files.update({name: picture_bytes(figure, kind) for kind, name in figure_names(title, pdf).items()})
    return files


def _lay_out(figure: "Figure") -> None:
    """Lay a figure out for good: saving lays it out for every file, and draws all of it once in vain for that."""
    engine = figure.get_layout_engine()
    if engine is not None:
        engine.execute(figure)
        figure.set_layout_engine("none")


def picture_bytes(figure: "Figure", kind: str) -> bytes:
    """Write a figure in a format that matplotlib knows, such as "png"."""
    buffer = io.BytesIO()
    # Without a date, the same figure always makes the same file.
    figure.savefig(buffer, format=kind, metadata={"CreationDate": None} if kind == "pdf" else None)
    return buffer.getvalue()
