"""The certificate in the summary."""

from typing import TYPE_CHECKING

from pipeline.config import Config
from pipeline.summary.pose_error import pose_error_part, pose_error_words
from pipeline.summary.section import SKIPPED, Section
from pipeline.summary.versions import versions

if TYPE_CHECKING:
    from collections.abc import Mapping

    from pipeline.bound.bound import Bound
    from pipeline.certify.bounds import Bounds
    from pipeline.certify.recheck.statement import StatedMachines
    from pipeline.certify.result import Certificate, Tolerance


def certificate_section(certificate: "Certificate") -> Section:
    """Give the verdict and the bounds of the proof; tolerances are null if they were not searched."""
    bounds, lengths, coordinates = certificate.bounds, certificate.link_length, certificate.coordinates
    assert bounds is not None, "a certified path has boxes"
    return {
        "status": "done",
        "verdict": certificate.verdict,
        "boxes": len(certificate.chain.boxes),
        "kappa_bound": bounds.kappa,
        "det_sign": bounds.det_sign,
        "min_distance_bound_m": min(bounds.distances_m.tolist(), default=None),
        "max_tilt_bound_deg": float(bounds.tilt_deg.max()),
        "goal_miss": bounds.goal_miss,
        "tolerance_m": None if lengths is None else lengths.eps_m,
        "tolerance_fails_m": None if lengths is None else lengths.fails_m,
        "coordinates_tolerance_m": None if coordinates is None else coordinates.eps_m,
        "coordinates_tolerance_fails_m": None if coordinates is None else coordinates.fails_m,
        **_body_part(bounds),
        **_avoided_part(bounds),
        **_following_part(certificate),
        **machines_part(None),
        **pose_error_part(None),
        "least_kappa": None,
        "least_kappa_boxes": None,
    }


def every_path_section(bound: "Bound") -> Section:
    """Give what kappa is at least, somewhere on every path, and with how many boxes that was proven."""
    return {
        "least_kappa": bound.least_kappa,
        "least_kappa_boxes": sum(attempt.boxes for attempt in bound.attempts),
    }


def _body_part(bounds: "Bounds") -> Section:
    """Give the least of the proven distances of bodies, and from obstacles, where there are any."""
    return {
        f"min_{what}_distance_bound_m": min(ranges.values[:, 0].tolist(), default=None)
        for what in ("body", "obstacle")
        if (ranges := bounds.ranges.get(f"{what}_distance_m")) is not None
    }


def _avoided_part(bounds: "Bounds") -> Section:
    """Give how far outside the boxes to avoid the motion stays, in metres or radians, where there are any."""
    ranges = bounds.ranges.get("avoided_by")
    return {} if ranges is None else {"avoided_by_bound": float(ranges.values[:, 0].min())}


def _following_part(certificate: "Certificate") -> Section:
    """Give how far the actuators may be from where they are commanded; null if that was not searched.

    Two different claims. The keys that begin with `following_` alone: every limit of kappa, distances, joints and
    boxes to avoid is kept. `following_on_branch_`: the motion stays regular and on its branch, whatever limits it
    breaks.
    """
    following = certificate.following
    within, branch = ({}, {}) if following is None else (following.within_limits, following.on_branch)
    calibrated = None if following is None else following.calibrated
    common = within.get("common")
    return {
        **_tolerances(within, "following"),
        "following_tilt_reserve_deg": None if common is None else common.tilt_reserve_deg,
        **_tolerances(branch, "following_on_branch"),
        "following_calibrated_m": None if calibrated is None else calibrated.eps_m,
    }


def _tolerances(found: "Mapping[str, Tolerance]", key: str) -> Section:
    """Give tolerances under keys with a beginning: common, by velocity, and of each actuator alone."""
    common, by_velocity = found.get("common"), found.get("by_velocity")
    errors = None if by_velocity is None or by_velocity.chain is None else by_velocity.chain.uncertainty.actuator_m
    alone = [one.eps_m for name, one in found.items() if name not in ("common", "by_velocity")]
    return {
        f"{key}_m": None if common is None else common.eps_m,
        f"{key}_fails_m": None if common is None else common.fails_m,
        f"{key}_by_velocity_m": errors,
        f"{key}_out_of_step_s": None if by_velocity is None else by_velocity.late_s,
        f"{key}_alone_m": alone or None,
        f"{key}_stopped_by": {name: _stop(one) for name, one in found.items()} or None,
    }


def _stop(tolerance: "Tolerance") -> Section | None:
    """Give what stopped the search of a tolerance, and where; None if nothing did."""
    stop = tolerance.stopped_by
    return None if stop is None else {"limit": stop.reason.limit, "s": stop.s}


def _stopped(section: Section, key: str) -> str:
    """Say what stopped the errors of all drives alike."""
    stop = (section.get(f"{key}_stopped_by") or {}).get("common")
    return "" if stop is None else f" (stopped by {stop['limit']} at s = {stop['s']:.3f})"


def certificate_facts(config: Config, seconds: float) -> Section:
    """Give the facts in the certificate's file about how it was made."""
    return {
        "settings": config.certify.model_dump(mode="json"),
        "versions": versions(),
        "seconds": seconds,
    }


def skipped_certificate() -> Section:
    """Say that nothing was proven."""
    return {"status": SKIPPED, "verdict": SKIPPED}


def certificate_in_summary(section: Section | None) -> Section:
    """Give the section with a verdict in any case: a failed proof has none of its own."""
    return {"verdict": "not certified", **(skipped_certificate() if section is None else section)}


def certificate_words(section: Section) -> str:
    """Say the key figures in words."""
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
    if (following := section.get("following_m")) is not None:
        branch = section["following_on_branch_m"]
        found += (
            f"; all drives may be off by {1e3 * following:.2f} mm with kappa, distances and joints within their "
            f"limits{_stopped(section, 'following')}, and by {1e3 * branch:.2f} mm before the motion could leave its "
            f"branch, limits broken{_stopped(section, 'following_on_branch')}"
        )
    if (least := section.get("least_kappa")) is not None:
        found += f"; no path can have a largest kappa below {least:.2f}"
    distances = {
        "axes at least {:.4f} m apart": section["min_distance_bound_m"],
        "bodies at least {:.4f} m apart": section.get("min_body_distance_bound_m"),
        "obstacles at least {:.4f} m away": section.get("min_obstacle_distance_bound_m"),
        "boxes to avoid at least {:.4f} m or rad away": section.get("avoided_by_bound"),
    }
    apart = "".join(f", {text.format(least)}" for text, least in distances.items() if least is not None)
    bounds = f"kappa at most {section['kappa_bound']:.2f}{apart}"
    found += machines_words(section) + pose_error_words(section)
    return f"{section['verdict']} by {section['boxes']:,} boxes: {bounds}{found}"


def machines_part(stated: "StatedMachines | None") -> Section:
    """Give deviations, probability and number of boxes of the proof, and whether limits are kept; null without one."""
    return {
        "calibrated_sigma": None if stated is None else stated.sigma,
        "calibrated_probability": None if stated is None else stated.probability,
        "calibrated_boxes": None if stated is None else stated.boxes,
        "calibrated_within_limits": None if stated is None else stated.within_limits,
        "calibrated_ranges_kept": None if stated is None else stated.ranges_kept,
        "calibrated_tilt_reserve_deg": None if stated is None else stated.tilt_reserve_deg,
        "calibrated_actuator_reserve_m": None if stated is None else stated.actuator_reserve_m,
    }


def machines_words(section: Section) -> str:
    """Say for which machines of a calibration the motion is proven, after the rest of the certificate."""
    if (sigma := section.get("calibrated_sigma")) is None:
        return ""
    kept = (
        "with kappa, distances and joints within their limits"
        if section["calibrated_within_limits"]
        else "as regular and on its branch (limits may be broken)"
    )
    return f"; proven for every machine within {sigma:.3g} standard deviations of its calibration, {kept}"


def proof_words(stated: "StatedMachines", broken: str | None) -> str:
    """Say what was proven, for which machines, what that means, and what is in reserve."""
    kept = (
        "stays on its branch, meets no singularity, and keeps the limits of kappa, distances and joints"
        if broken is None
        else f"stays on its branch and meets no singularity; limits are not proven to be kept ({broken})"
    )
    reserve = "limits of these are kept" if stated.ranges_kept else "not all limits of these have that in reserve"
    tilts = f"{max(stated.tilt_reserve_deg):.3f} degrees"
    drives = f"{1e3 * max(stated.actuator_reserve_m):.3f} mm"
    return (
        f"proven by {stated.boxes:,} boxes: the motion {kept},\n"
        f"for every machine within {stated.sigma:.4g} standard deviations of every combination of its parameters.\n"
        f"All {stated.dimensions} directions together are within with a probability of {stated.probability:.4g}.\n"
        f"Machines are off the path by at most {tilts} of tilt and {drives} of travel and strokes: {reserve}."
    )
