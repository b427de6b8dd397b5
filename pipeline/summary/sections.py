"""The parts of `summary.json`: every figure of a run, and honest words where there is none."""

import functools
import platform
from collections.abc import Mapping
from importlib import metadata
from typing import TYPE_CHECKING, Any

import numpy as np

from pipeline.config import Config
from pipeline.config.file import config_sha256

if TYPE_CHECKING:
    from pipeline.certify import Certificate
    from pipeline.refine.measure import PathFigures
    from pipeline.refine.result import Refinement
    from pipeline.retime import TrajectoryFigures, Usage
    from pipeline.route.regions.build import RegionTable
    from pipeline.route.result import Route

PACKAGE = "gantry-tau"
SKIPPED = "skipped"
_LIBRARIES = ("numpy", "scipy", "highspy", "casadi", "toppra", "python-flint", "matplotlib", "plotly")
_TERMS = 13
"""Variables of the paper's model per step beside one binary for each region."""

Section = dict[str, Any]


@functools.cache
def package_version() -> str:
    """Version of the installed package."""
    return metadata.version(PACKAGE)


@functools.cache
def versions() -> dict[str, str]:
    """Versions of everything that has a say in the results."""
    known = {name: metadata.version(name) for name in (PACKAGE, *_LIBRARIES)}
    return {**known, "python": platform.python_version()}


def summarise(config: Config, sections: Mapping[str, Section]) -> Section:
    """Put the parts together; a part that is missing says that it was skipped.

    Parameters
    ----------
    sections : mapping
        Any of `regions`, `route`, `path`, `certificate`, `trajectory`, `figures`, each with its `seconds`.
    """
    return {
        "name": config.name,
        "config_sha256": config_sha256(config),
        "versions": versions(),
        **{name: sections.get(name, {"status": SKIPPED}) for name in ("regions", "route", "path")},
        "certificate": _with_verdict(sections.get("certificate", skipped_certificate())),
        **{name: sections.get(name, {"status": SKIPPED}) for name in ("trajectory", "figures")},
    }


def regions_section(config: Config, table: "RegionTable") -> Section:
    """Size of stage one: `nominal_variables` is what the paper's own model would have, (13 + count) N."""
    return {
        "status": "done",
        "count": len(table),
        "gates": table.gate_count,
        "nominal_variables": (_TERMS + len(table)) * config.route.step_budget,
    }


def route_section(route: "Route") -> Section:
    """Quality of the route and how it was proven; `steps` counts its distinct positions."""
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


def path_section(refinement: "Refinement", refined: "PathFigures", coarse: "PathFigures") -> Section:
    """Figures of the refined path, and of the coarse one measured in the same way."""
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
        "min_link_distance_m": refined.measures["min_link_distance_m"],
        "min_rail_distance_m": refined.measures["min_rail_distance_m"],
        "coarse_min_link_distance_m": coarse.measures["min_link_distance_m"],
        # The two distances keep their places, before that of the coarse path.
        **refined.measures,
        "det_sign_constant": refined.det_sign_constant,
        "modes": list(refined.modes),
        "mode_changes": refined.mode_changes,
    }


def certificate_section(certificate: "Certificate") -> Section:
    """Verdict and bounds of the proof; tolerances are null where they were not searched."""
    bounds, lengths, coordinates = certificate.bounds, certificate.link_length, certificate.coordinates
    assert bounds is not None, "a certified path has boxes"
    return {
        "status": "done",
        "verdict": certificate.verdict,
        "boxes": len(certificate.chain.boxes),
        "kappa_bound": bounds.kappa,
        "det_sign": bounds.det_sign,
        "min_distance_bound_m": min(bounds.distances_m.tolist(), default=None),
        "max_tilt_bound_deg": float(np.rad2deg(bounds.tilt_rad.max())),
        "goal_miss": bounds.goal_miss,
        "tolerance_m": None if lengths is None else lengths.eps_m,
        "tolerance_fails_m": None if lengths is None else lengths.fails_m,
        "coordinates_tolerance_m": None if coordinates is None else coordinates.eps_m,
        "coordinates_tolerance_fails_m": None if coordinates is None else coordinates.fails_m,
    }


def certificate_facts(config: Config, seconds: float) -> Section:
    """What a certificate's file says of how it came about."""
    return {
        "settings": config.certify.model_dump(mode="json"),
        "versions": versions(),
        "seconds": seconds,
    }


def skipped_certificate() -> Section:
    """Say that nothing was proven."""
    return {"status": SKIPPED, "verdict": SKIPPED}


def _with_verdict(section: Section) -> Section:
    """A proof that failed has no verdict of its own: the path is not certified."""
    return {"verdict": "not certified", **section}


def trajectory_section(figures: "TrajectoryFigures") -> Section:
    """Duration, how near it is to the shortest possible one, and the largest fraction of each limit.

    `usage` has a number per actuator (link forces: per link; TCP: one), `peak` the largest magnitudes in SI units
    whether or not there is a limit; "skipped" stands where there is no limit, or no masses to compute forces from.
    """
    # Not above: a help text must not wait for stage three to load.
    from pipeline.retime.quantities import KINDS

    section = {
        "status": "done",
        "duration_s": figures.duration_s,
        "period_s": figures.period_s,
        "samples": figures.samples,
        "dwell_s": figures.dwell_s,
        "usage": _usage(figures.usage),
        "peak": {kind.name: figures.usage.peaks.get(kind.name, SKIPPED) for kind in KINDS},
    }
    if (quality := figures.quality) is not None:
        section |= {
            "jerk": "limited" if quality.jerk_limited else "not limited",
            "motion_s": quality.motion_s,
            "duration_without_jerk_s": quality.fastest_s,
            "duration_bound_s": quality.bound_s,
            "gap": quality.gap,
            "jerk_cost": quality.jerk_cost,
            "grid_points": quality.grid_points,
            "jerk_pieces": quality.pieces,
            "jerk_rounds": quality.rounds,
            "jerk_iterations": quality.iterations,
        }
    return section


def back_section(figures: "TrajectoryFigures") -> Section:
    """Duration of the way back, and the largest fraction of each limit."""
    return {
        "status": "done",
        "duration_s": figures.duration_s,
        "samples": figures.samples,
        "usage": _usage(figures.usage),
    }


def failed_part(section: Section) -> Section | None:
    """The part of a stage that failed though the stage has a result: why, and what to change; None: none did."""
    back: Section = section.get("back", {})
    return back if back.get("status") == "failed" else None


def _usage(usage: "Usage") -> Section:
    from pipeline.retime.quantities import KINDS

    values = {kind.name: getattr(usage, kind.name) for kind in KINDS}
    return {name: SKIPPED if value is None else value for name, value in values.items()}


def failure_section(reason: str, advice: str, status: str = "failed") -> Section:
    """A stage without a result: why, and what to change."""
    return {"status": status, "reason": reason, "advice": advice}
