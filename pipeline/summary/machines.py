"""What is proven of all machines that a calibration leaves possible, in the summary."""

from typing import TYPE_CHECKING

from pipeline.summary.section import Section

if TYPE_CHECKING:
    from pipeline.certify.recheck.statement import StatedMachines


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
    reserve = "these limits are kept, too" if stated.ranges_kept else "not all of these limits have that in reserve"
    tilts = f"{max(stated.tilt_reserve_deg):.3f} degrees"
    drives = f"{1e3 * max(stated.actuator_reserve_m):.3f} mm"
    return (
        f"proven by {stated.boxes:,} boxes: the motion {kept},\n"
        f"for every machine within {stated.sigma:.4g} standard deviations of every combination of its parameters.\n"
        f"All {stated.dimensions} directions together are within with a probability of {stated.probability:.4g}.\n"
        f"Machines are off the path by at most {tilts} of tilt and {drives} of travel and strokes: {reserve}."
    )
