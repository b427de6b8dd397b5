"""A report as one self-contained HTML page: styles, scripts, the plotting library and all numbers are in it."""

from functools import cache
from importlib import resources

from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup
from plotly.offline import get_plotlyjs

from pipeline.report.data import Report
from pipeline.report.payload import COLOURS, payload

_PACKAGE = "pipeline.report"
_ASSETS = "assets"
_TEMPLATE = "page.html.j2"
_STYLES = "page.css"
_SCRIPTS = (
    "data.js",
    "points.js",
    "machine.js",
    "map.js",
    "panels.js",
    "timeline.js",
    "proof.js",
    "readout.js",
    "player.js",
    "main.js",
)
"""In the order in which they run: each uses what earlier ones define."""


def render_page(report: Report) -> str:
    """Render the page. All text of the report is escaped; only the assets of this package are inserted as they are."""
    return (
        _environment()
        .get_template(_TEMPLATE)
        .render(
            report=report,
            colours=COLOURS,
            payload=payload(report) if report.motions or report.proof else None,
            styles=_asset(_STYLES),
            scripts=[_asset(name) for name in _SCRIPTS],
            plotly=Markup(get_plotlyjs()),
        )
    )


@cache
def _environment() -> Environment:
    environment = Environment(
        loader=PackageLoader(_PACKAGE, _ASSETS),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    # The refined motion comes first, and must stay there.
    environment.policies["json.dumps_kwargs"] = {"sort_keys": False, "separators": (",", ":"), "allow_nan": False}
    return environment


def _asset(name: str) -> Markup:
    return Markup((resources.files(_PACKAGE) / _ASSETS / name).read_text("utf-8"))
