"""The route in the summary."""

from typing import TYPE_CHECKING

from pipeline.summary.section import Section

if TYPE_CHECKING:
    from pipeline.route.result import Route


def route_section(route: "Route") -> Section:
    """Give the quality of the route and how it was proven; `steps` counts its distinct positions."""
    search = route.search
    return {
        "status": str(route.status),
        "solver": search.solver,
        "objective": route.objective,
        "bound": search.bound,
        "gap": search.gap,
        "steps": len(route),
        "kappa_max": route.kappa_max,
        "mode_changes": route.mode_changes,
        "relaxation": search.relaxation,
        "threshold": search.threshold,
        "core_regions": search.core_regions,
        "core_columns": search.core_columns,
        "moves": search.moves,
        "rounds": search.rounds,
        "followed_moves": search.followed_moves,
        "forbidden_moves": search.forbidden_moves,
    }


def route_words(section: Section) -> str:
    """Say the key figures in words."""
    return (
        f"{section['steps']} positions, {section['mode_changes']} mode changes; "
        f"sum of kappa {section['objective']:.1f} (gap {section['gap']:.2%}), largest {section['kappa_max']:.1f}"
    )
