"""A report as one self-contained HTML page: styles, scripts, the plotting library and all numbers are in it."""

import json
from dataclasses import asdict
from functools import cache
from importlib import resources

from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup

from pipeline.report import palette
from pipeline.report.data import Report
from pipeline.report.descriptions import describe_plots
from pipeline.report.embedding import compressed, drawing_library, security_policy
from pipeline.report.payload import payload

_PACKAGE = "pipeline.report"
_ASSETS = "assets"
_TEMPLATE = "page.html.j2"
_STYLES = "page.css"
_SCRIPTS = (
    "library.js",
    "data.js",
    "bodies.js",
    "points.js",
    "camera.js",
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
    styles = f"{theme()}\n{asset(_STYLES)}"
    script = "".join(asset(name) for name in _SCRIPTS)
    library, packed_library = drawing_library()
    draws = bool(report.motions or report.proof)
    return (
        _environment()
        .get_template(_TEMPLATE)
        .render(
            report=report,
            alt=describe_plots(report),
            policy=security_policy((script, library) if draws else (), (styles,)),
            styles=Markup(styles),
            script=Markup(script),
            numbers=_numbers(report) if draws else None,
            library=packed_library,
        )
    )


def _numbers(report: Report) -> str:
    # The refined motion comes first, and must stay there.
    return compressed(json.dumps(payload(report), separators=(",", ":"), allow_nan=False))


def theme() -> str:
    """Write the colours as custom properties: dark ones on screens whose user prefers them; paper is light."""
    light, dark = (
        " ".join(f"--{name}: {colour};" for name, colour in asdict(colours).items())
        for colours in (palette.LIGHT, palette.DARK)
    )
    shared = f"--singular: {palette.SINGULAR}; --unreachable: {palette.OUT_OF_REACH};"
    return (
        f":root {{ color-scheme: light; {light} {shared} }}\n"
        f".map {{ --refined: {palette.LIGHT.refined}; --coarse: {palette.LIGHT.coarse}; }}\n"
        f"@media screen and (prefers-color-scheme: dark) {{ :root {{ color-scheme: dark; {dark} }} }}"
    )


@cache
def _environment() -> Environment:
    return Environment(
        loader=PackageLoader(_PACKAGE, _ASSETS),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )


@cache
def asset(name: str) -> str:
    """Read an asset of this package."""
    return (resources.files(_PACKAGE) / _ASSETS / name).read_text("utf-8")
