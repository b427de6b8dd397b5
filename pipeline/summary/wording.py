"""What a stage's part of the summary says, in a few words."""

from typing import Any

from pipeline.stage import Stage
from pipeline.summary.sections import failed_part


def key_figures(stage: Stage, section: dict[str, Any]) -> str:
    """Tell a stage's part of the summary in a few words."""
    return _TELL[stage](section)


def _regions(section: dict[str, Any]) -> str:
    return f"{section['count']:,} regions, {section['gates']:,} of them gates"


def _route(section: dict[str, Any]) -> str:
    return (
        f"{section['steps']} positions, {section['mode_changes']} mode changes; "
        f"sum of kappa {section['objective']:.1f} (gap {section['gap']:.2%}), largest {section['kappa_max']:.1f}"
    )


def _path(section: dict[str, Any]) -> str:
    coarse, refined = section["coarse_kappa_integral"], section["kappa_integral"]
    return (
        f"kappa integral {refined:.1f} ({refined / coarse - 1.0:+.1%} against the coarse path's {coarse:.1f}), "
        f"largest {section['kappa_max']:.1f}; links at least {section['min_link_distance_m']:.4f} m apart"
    )


def _certificate(section: dict[str, Any]) -> str:
    if section["verdict"] != "certified":
        return str(section["verdict"])
    tolerance = section["tolerance_m"]
    found = (
        ""
        if tolerance is None
        else (
            f"; link lengths may be wrong by {1e3 * tolerance:.2f} mm, every coordinate by "
            f"{1e3 * section['coordinates_tolerance_m']:.3f} mm"
        )
    )
    return (
        f"{section['verdict']} by {section['boxes']:,} boxes: kappa at most {section['kappa_bound']:.2f}, "
        f"axes at least {section['min_distance_bound_m']:.4f} m apart{found}"
    )


def _trajectory(section: dict[str, Any]) -> str:
    used = {name: max(values) for name, values in section["usage"].items() if not isinstance(values, str)}
    parts = ", ".join(f"{share:.0%} of {name.replace('_', ' ').replace('tcp', 'TCP')}" for name, share in used.items())
    told = f"{section['duration_s']:.2f} s, {section['samples']:,} rows {section['period_s']:g} s apart; up to {parts}"
    if "gap" in section:
        told += f"; {section['jerk_cost']:+.1%} for jerk, {section['gap']:.2%} above the bound without"
    if failed_part(section):
        told += "; the way back failed"
    return told


def _figures(section: dict[str, Any]) -> str:
    return f"{section['count']} pictures"


_TELL = {
    Stage.REGIONS: _regions,
    Stage.ROUTE: _route,
    Stage.REFINE: _path,
    Stage.CERTIFY: _certificate,
    Stage.RETIME: _trajectory,
    Stage.FIGURES: _figures,
}
