"""The pictures of a study as plain data for plotly: traces and a layout each."""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from pipeline.figures import style
from pipeline.study.report.pareto import front, numeric
from pipeline.study.rows import Ending
from pipeline.study.table import Table

MOST_POINTS = 5_000
"""Runs that pictures show at most, spread evenly over the design."""
_MOST_GROUPS = 24
_MOST_AXES = 12
_PANEL_PX = 190
_COLOURS = {
    Ending.DONE: style.BLUE,
    Ending.NO_SOLUTION: style.VERMILLION,
    Ending.REFUSED: style.ORANGE,
    Ending.TIME_LIMIT: style.PURPLE,
    Ending.KILLED: style.BLACK,
    Ending.ERROR: style.GREY,
}


@dataclass(frozen=True)
class Plot:
    """A picture: its title, what it shows, and its data for plotly."""

    title: str
    about: str
    figure: dict[str, Any]


def parallel(table: Table, figures: Sequence[str]) -> Plot | None:
    """Draw every run that is done as a line across parameters and figures; None if there are none."""
    done = _thinned([k for k, status in enumerate(table.columns["status"]) if status == Ending.DONE])
    shown = [*table.parameters, *figures][:_MOST_AXES]
    if len(done) < 2 or len(shown) < 2:
        return None
    axes = [_axis(name, [table.columns[name][k] for k in done]) for name in shown]
    colour = axes[-1]["values"]
    trace = {
        "type": "parcoords",
        "dimensions": axes,
        "line": {"color": colour, "colorscale": "Viridis", "showscale": False},
        "labelangle": -12,
    }
    layout = {"height": 460, "margin": {"l": 70, "r": 60, "t": 90, "b": 30}}
    return Plot(
        "Parallel coordinates",
        "Every line is a run that is done. Drag along an axis to keep runs in that range, drag its name to move it.",
        {"data": [trace], "layout": layout},
    )


def by_parameter(table: Table, name: str, figures: Sequence[str]) -> Plot:
    """Draw how runs end over one parameter, and their figures, a panel each."""
    values = table.columns[name]
    ordered = _ordered(values)
    grouped = len(ordered) <= _MOST_GROUPS
    traces = _endings(table, values, ordered) if grouped else []
    panels = ([""] if grouped else []) + list(figures)
    for figure in figures:
        axis = _suffix(panels.index(figure))
        traces.append(_points(table, values, figure, axis, [_text(one) for one in ordered] if grouped else None))
    return Plot(f"Over {name}", "", {"data": traces, "layout": _stacked(panels, name, grouped)})


def pareto(table: Table, names: Sequence[str]) -> Plot | None:
    """Draw two objectives against each other, with the runs that no other beats; None without two."""
    if len(names) < 2:
        return None
    x, y = (name.lstrip("-") for name in names[:2])
    best = set(front(table, names))
    done = [k for k, status in enumerate(table.columns["status"]) if status == Ending.DONE]
    others = _thinned([k for k in done if k not in best])
    in_order = sorted(best, key=lambda k: table.columns[x][k])
    rest = _scatter(table, others, (x, y), {"name": "other runs", "marker": {"color": style.GREY, "size": 6}})
    line = {"name": "Pareto front", "mode": "lines+markers", "marker": {"color": style.VERMILLION, "size": 9}}
    line["line"] = {"shape": "hv" if not any(name.startswith("-") for name in names[:2]) else "linear", "width": 1}
    traces = [rest, _scatter(table, in_order, (x, y), line)]
    layout = {"height": 460, "xaxis": {"title": {"text": x}}, "yaxis": {"title": {"text": y}}}
    wanted = ", ".join(f"{'more' if name.startswith('-') else 'less'} {name.lstrip('-')}" for name in names)
    return Plot("Pareto front", f"Runs that no other beats in all of: {wanted}.", {"data": traces, "layout": layout})


def failures(table: Table) -> Plot | None:
    """Draw how many runs ended without a result, by reason; None if there are none."""
    counts = Counter(reason for reason in table.columns["reason"] if reason)
    if not counts:
        return None
    reasons = [reason for reason, _ in reversed(counts.most_common())]
    counted = [counts[one] for one in reasons]
    trace = {"type": "bar", "orientation": "h", "y": reasons, "x": counted, "marker": {"color": style.VERMILLION}}
    layout = {"height": 120 + 34 * len(reasons), "margin": {"l": 220}, "xaxis": {"title": {"text": "runs"}}}
    return Plot("Runs without a result, by reason", "", {"data": [trace], "layout": layout})


def shown_figures(table: Table, names: Sequence[str], objectives: Sequence[str]) -> tuple[str, ...]:
    """Choose the figures that pictures show: objectives, then those asked for, as far as they are numbers."""
    wanted = dict.fromkeys([*(name.lstrip("-") for name in objectives), *names])
    return numeric(table, tuple(wanted))[:4]


def _endings(table: Table, values: list[Any], ordered: list[Any]) -> list[dict[str, Any]]:
    counts = Counter(zip(table.columns["status"], map(_text, values), strict=True))
    labels = [_text(one) for one in ordered]
    return [
        {
            "type": "bar",
            "name": ending.value,
            "x": labels,
            "y": [counts[(ending.value, label)] for label in labels],
            "marker": {"color": colour},
            "xaxis": "x",
            "yaxis": "y",
        }
        for ending, colour in _COLOURS.items()
        if any(counts[(ending.value, label)] for label in labels)
    ]


def _points(table: Table, values: list[Any], figure: str, axis: str, labels: list[str] | None) -> dict[str, Any]:
    done = _thinned([k for k, status in enumerate(table.columns["status"]) if status == Ending.DONE])
    return {
        "type": "scatter",
        "mode": "markers",
        "name": figure,
        "x": [_text(values[k]) if labels else values[k] for k in done],
        "y": [table.columns[figure][k] for k in done],
        "text": [f"run {table.columns['number'][k]}" for k in done],
        "marker": {"color": style.BLUE, "size": 7, "opacity": 0.7},
        "showlegend": False,
        "xaxis": "x",
        "yaxis": f"y{axis}",
    }


def _stacked(panels: list[str], name: str, grouped: bool) -> dict[str, Any]:
    """Lay panels out one above the other, over one x axis."""
    count = max(len(panels), 1)
    x = {"title": {"text": name}, "anchor": f"y{_suffix(count - 1)}"} | ({"type": "category"} if grouped else {})
    layout: dict[str, Any] = {"height": 130 + _PANEL_PX * count, "xaxis": x, "barmode": "stack"}
    for index, panel in enumerate(panels):
        top = 1.0 - index / count
        title = {"text": panel or "runs", "font": {"size": 12}}
        layout[f"yaxis{_suffix(index)}"] = {"domain": [top - 0.86 / count, top], "title": title}
    return layout


def _suffix(index: int) -> str:
    return "" if index == 0 else str(index + 1)


def _scatter(table: Table, rows: list[int], names: tuple[str, str], looks: dict[str, Any]) -> dict[str, Any]:
    x, y = (table.columns[name] for name in names)
    about = [
        f"run {table.columns['number'][k]}<br>" + "<br>".join(f"{p} = {table.columns[p][k]}" for p in table.parameters)
        for k in rows
    ]
    return {
        "type": "scatter",
        "mode": "markers",
        "x": [x[k] for k in rows],
        "y": [y[k] for k in rows],
        "text": about,
        **looks,
    }


def _axis(name: str, values: list[Any]) -> dict[str, Any]:
    """Make an axis of numbers; words get a number each, in their order."""
    if all(value is None or (isinstance(value, int | float) and not isinstance(value, bool)) for value in values):
        return {"label": name, "values": values}
    words = [_text(one) for one in _ordered(values)]
    places = {word: index for index, word in enumerate(words)}
    numbers = [places[_text(value)] for value in values]
    return {"label": name, "values": numbers, "tickvals": list(places.values()), "ticktext": words}


def _ordered(values: list[Any]) -> list[Any]:
    """List distinct values: numbers by size, words as they come first."""
    distinct = list(dict.fromkeys(values))
    numbers = all(isinstance(value, int | float) and not isinstance(value, bool) for value in distinct)
    return sorted(distinct) if numbers else distinct


def _text(value: object) -> str:
    return f"{value:g}" if isinstance(value, float) else "" if value is None else str(value)


def _thinned(rows: list[int]) -> list[int]:
    if len(rows) <= MOST_POINTS:
        return rows
    return [rows[k] for k in np.linspace(0, len(rows) - 1, MOST_POINTS).astype(int)]
