"""The pictures of a study as plain data for plotly: traces and a layout each."""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.colors import to_hex

from pipeline.figures import style
from pipeline.study.report.pareto import front, numeric
from pipeline.study.rows import Ending
from pipeline.study.table import Table, figure_column

MOST_POINTS = 5_000
"""Runs that pictures show at most, spread evenly over the design."""
_MOST_GROUPS = 24
SHADES = tuple(to_hex(mpl.colormaps["viridis_r"](part)) for part in (0.05, 0.25, 0.45, 0.65, 0.85))
"""Colours of lines, from the least to the largest of what they are drawn by."""
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
    shown = [*varied(table), *figures][:_MOST_AXES]
    if len(done) < 2 or len(shown) < 2:
        return None
    axes = [_axis(name, [table.columns[name][k] for k in done]) for name in shown]
    shades = _shades(axes[-1].heights)
    traces = []
    for shade, colour in enumerate(SHADES):
        mine = [k for k in range(len(done)) if shades[k] == shade]
        traces.append(_lines(axes, mine, [table.columns["number"][done[k]] for k in mine], colour))
    layout = {
        "height": 460,
        "showlegend": False,
        "hovermode": "closest",
        "margin": {"l": 70, "r": 70, "t": 20, "b": 110},
        "xaxis": {
            "tickvals": list(range(len(axes))),
            "ticktext": shown,
            "tickangle": -20,
            "showgrid": True,
            "range": [-0.2, len(axes) - 0.8],
            "fixedrange": True,
        },
        "yaxis": {"visible": False, "range": [-0.06, 1.06], "fixedrange": True},
        "annotations": [note for place, axis in enumerate(axes) for note in axis.notes(place)],
    }
    about = f"Every line is a run that is done, from yellow (least) to violet (most) of {shown[-1]}."
    return Plot("Parallel coordinates", about, {"data": traces, "layout": layout})


def by_parameter(table: Table, name: str, figures: Sequence[str]) -> Plot:
    """Draw how runs end over one parameter, and their figures, a panel each."""
    values = table.columns[name]
    ordered = _ordered(values)
    grouped = len(ordered) <= _MOST_GROUPS
    traces = _endings(table, values, ordered) if grouped else []
    panels = ([""] if grouped else []) + list(figures)
    for figure in figures:
        axis = suffix(panels.index(figure))
        traces.append(_points(table, values, figure, axis, [_text(one) for one in ordered] if grouped else None))
    return Plot(f"Over {name}", "", {"data": traces, "layout": stacked(panels, name, grouped)})


def pareto(table: Table, names: Sequence[str]) -> Plot | None:
    """Draw two objectives against each other, with the runs that no other beats; None without two."""
    if len(names) < 2:
        return None
    x, y = (name.removeprefix("-") for name in names[:2])
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
    """Draw how many runs ended without a result, or beyond a constraint, by reason; None if there are none."""
    counts = Counter(reason for reason in table.columns["reason"] if reason)
    if not counts:
        return None
    reasons = [reason for reason, _ in reversed(counts.most_common())]
    counted = [counts[one] for one in reasons]
    trace = {"type": "bar", "orientation": "h", "y": reasons, "x": counted, "marker": {"color": style.VERMILLION}}
    layout = {"height": 120 + 34 * len(reasons), "margin": {"l": 220}, "xaxis": {"title": {"text": "runs"}}}
    return Plot("Runs that do not count, by reason", "", {"data": [trace], "layout": layout})


def varied(table: Table) -> tuple[str, ...]:
    """Name the parameters that have more than one value."""
    return tuple(name for name in table.parameters if len(set(table.columns[name])) > 1)


def shown_figures(table: Table, names: Sequence[str], objectives: Sequence[str]) -> tuple[str, ...]:
    """Choose the figures that pictures show: objectives, then those asked for, as far as they are numbers."""
    asked = (figure_column(name, table.parameters) for name in names)
    wanted = dict.fromkeys([*(name.removeprefix("-") for name in objectives), *asked])
    return (numeric(table, tuple(wanted)) or numeric(table, table.figures))[:4]


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


def stacked(panels: list[str], name: str, grouped: bool) -> dict[str, Any]:
    """Lay panels out one above the other, over one x axis."""
    count = max(len(panels), 1)
    x = {"title": {"text": name}, "anchor": f"y{suffix(count - 1)}"} | ({"type": "category"} if grouped else {})
    layout: dict[str, Any] = {"height": 130 + _PANEL_PX * count, "xaxis": x, "barmode": "stack"}
    for index, panel in enumerate(panels):
        top = 1.0 - index / count
        title = {"text": panel or "runs", "font": {"size": 12}}
        layout[f"yaxis{suffix(index)}"] = {"domain": [top - 0.86 / count, top], "title": title}
    return layout


def suffix(index: int) -> str:
    """Give the number that plotly has in the name of an axis: the first has none."""
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


@dataclass(frozen=True)
class _Axis:
    """An axis of parallel coordinates: heights from 0 to 1, of runs and of the texts beside it."""

    heights: list[float | None]
    ticks: dict[float, str]

    def notes(self, place: int) -> list[dict[str, Any]]:
        """Write the texts beside the axis."""
        common = {"x": place, "xanchor": "left", "xshift": 4, "showarrow": False, "font": {"size": 11}}
        return [{**common, "y": height, "text": text} for height, text in self.ticks.items()]


def _axis(name: str, values: list[Any]) -> _Axis:
    """Make an axis of numbers; words get a height each, in their order."""
    distinct = [value for value in _ordered(values) if value is not None]
    if len(distinct) > 1 and all(_is_number(value) for value in distinct):
        low, high = distinct[0], distinct[-1]
        heights = [None if value is None else (value - low) / (high - low) for value in values]
        return _Axis(heights, {0.0: f"{low:.4g}", 1.0: f"{high:.4g}"})
    spots = np.linspace(0.0, 1.0, len(distinct)) if len(distinct) > 1 else [0.5] * len(distinct)
    places = {_text(value): float(spot) for value, spot in zip(distinct, spots, strict=True)}
    shown = places if len(places) <= _MOST_GROUPS else {}
    return _Axis([places.get(_text(value)) for value in values], {spot: text for text, spot in shown.items()})


def _shades(heights: list[float | None]) -> list[int]:
    return [min(int((height or 0.0) * len(SHADES)), len(SHADES) - 1) for height in heights]


def _lines(axes: list[_Axis], runs: list[int], numbers: list[int], colour: str) -> dict[str, Any]:
    """Draw runs as lines of one colour: one trace, with gaps between them."""
    x = [place for _ in runs for place in (*range(len(axes)), None)]
    y = [height for run in runs for height in (*(axis.heights[run] for axis in axes), None)]
    text = [label for number in numbers for label in (*[f"run {number}"] * len(axes), "")]
    line = {"color": colour, "width": 1.2}
    return {"type": "scatter", "mode": "lines", "x": x, "y": y, "text": text, "hoverinfo": "text", "line": line}


def _ordered(values: list[Any]) -> list[Any]:
    """List distinct values: numbers by size, words as they come first."""
    distinct = list(dict.fromkeys(values))
    given = [value for value in distinct if value is not None]
    return sorted(given) if all(_is_number(value) for value in given) else distinct


def _is_number(value: object) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)


def _text(value: object) -> str:
    return f"{value:g}" if isinstance(value, float) else "" if value is None else str(value)


def _thinned(rows: list[int]) -> list[int]:
    if len(rows) <= MOST_POINTS:
        return rows
    return [rows[k] for k in np.linspace(0, len(rows) - 1, MOST_POINTS).astype(int)]
