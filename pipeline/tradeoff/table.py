"""Trade-offs as rows of text, and as data."""

from collections.abc import Sequence

from pipeline.config import Config
from pipeline.config.file import config_sha256
from pipeline.tradeoff.curve import MissingPoint, Tradeoff, TradeoffPoint

TABLE_HEADER = (
    "route",
    "weight",
    "duration s",
    "%",
    "kappa integral",
    "%",
    "largest kappa",
    "proven",
    "sign changes",
    "working modes",
)
"""Headings of `table_cells`."""


def table_cells(points: Sequence[TradeoffPoint]) -> list[tuple[str, ...]]:
    """Format points as text, with duration and integral in per cent against the first point."""
    return [_cells(point, points[0]) for point in points]


def _cells(point: TradeoffPoint, first: TradeoffPoint) -> tuple[str, ...]:
    return (
        str(point.route),
        weight_text(point.weight),
        f"{point.duration_s:.3f}",
        _per_cent(point.duration_s, first.duration_s),
        f"{point.kappa_integral:.1f}",
        _per_cent(point.kappa_integral, first.kappa_integral),
        f"{point.kappa_max:.2f}",
        f"{point.kappa_bound:.2f}",
        str(sum(point.quality.acceleration_sign_changes)),
        " ".join(point.modes),
    )


def weight_text(weight: float | None) -> str:
    """Name a weight; the path that does not consider time has none."""
    return "no time" if weight is None else f"{weight:g}"


def _per_cent(value: float, first: float) -> str:
    return "" if value == first else f"{100.0 * (value / first - 1.0):+.1f}"


def missing_text(missing: MissingPoint) -> str:
    """Say which point is missing, and why."""
    what = f"route {missing.route}" if missing.weight is None else f"route {missing.route}, weight {missing.weight:g}"
    return f"{what}: {missing.error.reason}"


def tradeoff_data(config: Config, tradeoff: Tradeoff) -> dict[str, object]:
    """Put a trade-off into plain data, unrounded; durations in seconds, integrals in steps of the route's metric."""
    return {
        "name": config.name,
        "config_sha256": config_sha256(config),
        "points": [_point_data(point) for point in tradeoff.points],
        "missing": [
            {
                "route": one.route,
                "weight": one.weight,
                "stage": one.error.stage,
                "reason": one.error.reason,
                "advice": one.error.advice,
            }
            for one in tradeoff.missing
        ],
    }


def _point_data(point: TradeoffPoint) -> dict[str, object]:
    quality = point.quality
    return {
        "route": point.route,
        "weight": point.weight,
        "modes": list(point.modes),
        "duration_s": point.duration_s,
        "kappa_integral": point.kappa_integral,
        "kappa_max": point.kappa_max,
        "verdict": "certified",
        "kappa_bound": point.kappa_bound,
        "boxes": point.boxes,
        "velocity_sign_changes": list(quality.velocity_sign_changes),
        "acceleration_sign_changes": list(quality.acceleration_sign_changes),
        "time_ratio": quality.time_ratio,
    }
