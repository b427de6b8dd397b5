"""The page of a study: one HTML file with styles, scripts, the plotting library and all numbers in it."""

import json
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from importlib import resources
from typing import Any

from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup

from pipeline.artifacts import jsonable
from pipeline.report.embedding import compressed, drawing_library, security_policy
from pipeline.report.page import asset, theme
from pipeline.study.config import Kind, StudyConfig
from pipeline.study.report.history import history
from pipeline.study.report.pareto import front, objectives
from pipeline.study.report.plots import by_parameter, failures, parallel, pareto, shown_figures, varied
from pipeline.study.rows import Ending
from pipeline.study.table import Table

REPORT = "report.html"
MOST_ROWS = 2_000
"""Runs that the page lists; the table of the study has all."""
_PACKAGE = "pipeline.study.report"
_STYLES, _LIBRARY = "page.css", "library.js"
"""Of the report of a run."""
_OWN_STYLES, _SCRIPT = "study.css", "study.js"


@dataclass(frozen=True)
class RunLine:
    """A run as the page lists it: its cells, how it ended, why, and the file that tells more."""

    cells: tuple[str, ...]
    status: str
    reason: str
    message: str
    seconds: float
    link: str


def render_study(study: StudyConfig, table: Table, total: int | None, link: Callable[[str], str]) -> bytes:
    """Render the page. All text of the study is escaped; only the assets of this program are inserted as they are.

    Parameters
    ----------
    total : int or None
        How many runs the study has, ended or not.
    link : callable
        Gives what to link to of a run, by its folder; both are relative to the page.
    """
    named = objectives(study.pareto, table)
    figures = shown_figures(table, study.figures, named)
    plots = [
        parallel(table, figures),
        pareto(table, named),
        history(table, named) if study.design.kind is Kind.OPTIMISE else None,
        *(by_parameter(table, name, figures) for name in varied(table)),
        failures(table),
    ]
    shown = [plot for plot in plots if plot is not None]
    lines = [
        _line(row, table.parameters, figures, link) for _, row in zip(range(MOST_ROWS), table.rows(), strict=False)
    ]
    styles = f"{theme()}\n{asset(_STYLES)}\n{_own(_OWN_STYLES)}"
    script = f"{asset(_LIBRARY)}\n{_own(_SCRIPT)}"
    library, packed_library = drawing_library()
    page = _environment().get_template("study.html.j2")
    return page.render(
        study=study,
        count=len(table),
        total=total,
        done=sum(status == Ending.DONE for status in table.columns["status"]),
        plots=shown,
        policy=security_policy((script, library), (styles,)),
        numbers=compressed(json.dumps([jsonable(plot.figure) for plot in shown], separators=(",", ":"))),
        header=(*table.parameters, *figures),
        lines=lines,
        best={table.columns["number"][index] for index in front(table, named)},
        styles=Markup(styles),
        script=Markup(script),
        library=packed_library,
    ).encode()


def _line(
    row: dict[str, Any], parameters: tuple[str, ...], figures: tuple[str, ...], link: Callable[[str], str]
) -> RunLine:
    cells = (row["number"], *(row[name] for name in (*parameters, *figures)))
    return RunLine(
        tuple(_text(cell) for cell in cells),
        row["status"],
        row["reason"] or "",
        (row["message"] or "").strip(),
        row["seconds"],
        link(row["run"]),
    )


def _text(value: object) -> str:
    return "" if value is None else f"{value:.6g}" if isinstance(value, float) else str(value)


@cache
def _environment() -> Environment:
    return Environment(
        loader=PackageLoader(_PACKAGE, "assets"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )


def _own(name: str) -> str:
    return (resources.files(_PACKAGE) / "assets" / name).read_text("utf-8")
