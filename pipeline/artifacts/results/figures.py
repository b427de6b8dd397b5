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
        for kind, name in figure_names(title, pdf).items():
            files[name] = picture_bytes(figure, kind)
            # The layout is fixed after the first: laying it out again takes as long as drawing.
            figure.set_layout_engine("none")
    return files


def picture_bytes(figure: "Figure", kind: str) -> bytes:
    """Write a figure in a format that matplotlib knows, such as "png"."""
    buffer = io.BytesIO()
    # Without a date, the same figure always makes the same file.
    figure.savefig(buffer, format=kind, metadata={"CreationDate": None} if kind == "pdf" else None)
    return buffer.getvalue()
