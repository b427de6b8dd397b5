"""The figures of the reference run that is kept in git."""

import json
from pathlib import Path
from typing import Any

from from_code.markdown import table

_SUMMARY = Path(__file__).parents[2] / "results" / "reference" / "agder" / "summary.json"


def reference_run() -> str:
    """List the key figures of every stage, and the seconds that it took."""
    summary = json.loads(_SUMMARY.read_text(encoding="utf-8"))
    rows = []
    for stage, figures in _figures(summary).items():
        seconds = f"{summary[stage]['seconds']:.1f}"
        for k, (figure, value) in enumerate(figures.items()):
            rows.append((stage if k == 0 else "", figure, value, seconds if k == 0 else ""))
    return table(("stage", "figure", "value", "seconds"), rows)


def _figures(summary: dict[str, Any]) -> dict[str, dict[str, str]]:
    regions, route, path, proof, motion = (
        summary[stage] for stage in ("regions", "route", "path", "certificate", "trajectory")
    )
    change = path["kappa_integral"] / path["coarse_kappa_integral"] - 1.0
    usage = {name: max(values) for name, values in motion["usage"].items() if not isinstance(values, str)}
    return {
        "regions": {
            "regions; gates among them": f"{regions['count']:,}; {regions['gates']:,}",
            "variables the paper's program would have": f"{regions['nominal_variables']:,}",
        },
        "route": {
            "status; gap": f"{route['status']}; {route['gap']:g}",
            "objective; positions; largest kappa": (
                f"{route['objective']:.2f}; {route['steps']}; {route['kappa_max']:.2f}"
            ),
        },
        "path": {
            "integral of kappa, coarse and refined": (
                f"{path['coarse_kappa_integral']:.1f}, {path['kappa_integral']:.1f} ({change:+.1%})"
            ),
            "largest kappa, coarse and refined": f"{path['coarse_kappa_max']:.2f}, {path['kappa_max']:.2f}",
            "least distance between link axes; largest tilt": (
                f"{path['min_link_distance_m']:.4f} m; {path['max_tilt_deg']:.1f} degrees"
            ),
        },
        "certificate": {"boxes; bound of kappa": f"{proof['boxes']}; {proof['kappa_bound']:.2f}"},
        "trajectory": {
            "duration": f"{motion['duration_s']:.2f} s",
            "largest use of limits": ", ".join(f"{name.replace('_', ' ')} {part:.0%}" for name, part in usage.items()),
        },
    }
