"""The refined path in the summary."""

from typing import TYPE_CHECKING

from pipeline.summary.section import QUALITY, Section

if TYPE_CHECKING:
    from pipeline.refine.measure import PathFigures
    from pipeline.refine.result import Refinement

CORRECTION = "correction"
"""The key of what was corrected, where a path was corrected for another machine rather than refined from a route."""


def path_section(refinement: "Refinement", refined: "PathFigures", coarse: "PathFigures") -> Section:
    """Give the figures of the refined path, and of the coarse one measured in the same way.

    `quality` has what is known of the motion without its time; `summary.whole` adds the rest.
    """
    return {
        "status": str(refinement.status),
        "iterations": refinement.iterations,
        "rounds": refinement.rounds,
        "meshes": refinement.meshes,
        "mesh_change": refinement.mesh_change,
        "nodes": refinement.nodes,
        "kappa_max": refined.kappa_max,
        "kappa_max_s": refined.kappa_max_s,
        "kappa_integral": refined.kappa_integral,
        "surrogate_integral": refinement.surrogate_integral,
        "coarse_kappa_max": coarse.kappa_max,
        "coarse_kappa_integral": coarse.kappa_integral,
        "length": refined.length,
        "coarse_length": coarse.length,
        "closure_residual_m": refined.closure_residual_m,
        **refined.measures,
        "coarse_min_link_distance_m": coarse.measures["min_link_distance_m"],
        "det_sign_constant": refined.det_sign_constant,
        "modes": list(refined.modes),
        "mode_changes": refined.mode_changes,
        QUALITY: {
            "actuator_length_m": refined.actuator_length_m,
            "actuator_distance_m": refined.actuator_distance_m,
            "length_ratio": refined.length_ratio,
        },
    }


def path_words(section: Section) -> str:
    """Say the key figures in words."""
    coarse, refined = section["coarse_kappa_integral"], section["kappa_integral"]
    distance = section.get("min_body_distance_m")
    bodies = "" if distance is None else f", bodies {distance:.4f} m"
    return (
        f"kappa integral {refined:.1f} ({refined / coarse - 1.0:+.1%} against the coarse path's {coarse:.1f}), "
        f"largest {section['kappa_max']:.1f}; links at least {section['min_link_distance_m']:.4f} m apart{bodies}"
    )
