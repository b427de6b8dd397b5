"""The route in the summary."""

from typing import TYPE_CHECKING

from pipeline.errors import NoSolutionError
from pipeline.status import Status
from pipeline.summary.objective_words import route_quantity
from pipeline.summary.section import Section

if TYPE_CHECKING:
    from pipeline.route.result import Route


def route_section(route: "Route") -> Section:
    """Give the quality of the route and how it was proven; `steps` counts its distinct positions."""
    search = route.search
    return {
        "status": str(route.status),
        "solver": search.solver,
        "objective_kind": str(route.objective_kind),
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
    quantity = route_quantity(section)
    return (
        f"{section['steps']} positions, {section['mode_changes']} mode changes; {quantity.name} "
        f"{quantity.shown(section['objective'])} (gap {section['gap']:.2%}), largest kappa {section['kappa_max']:.1f}"
    )


def unproven_route(section: Section) -> NoSolutionError | None:
    """Make the error with which a run stops at a route that is not proven optimal; None for one that is."""
    if section["status"] != Status.UNPROVEN:
        return None
    quantity = route_quantity(section)
    objective, bound = (quantity.shown(section[key], 3) for key in ("objective", "bound"))
    return NoSolutionError(
        "route",
        f"not proven optimal: the search ended at route.time_limit_s, after {section['seconds']:.0f} s. The best route "
        f"so far has a {quantity.name} of {objective}; none has less than {bound} (proven), a gap of "
        f"{section['gap']:.2%}",
        "raise route.time_limit_s for a proof, or go on with this route as it is: the same command (run, refine, "
        "certify or retime) with --unproven, which does not search again",
        {"status": section["status"], **{key: section[key] for key in ("objective", "bound", "gap")}},
    )
