"""The trajectory in the summary."""

from typing import TYPE_CHECKING

from pipeline.summary.section import QUALITY, SKIPPED, Section, failed_part

if TYPE_CHECKING:
    from collections.abc import Iterable

    from pipeline.retime import Interpolation, MotionProof, MotionQuality, TimingReport, TrajectoryFigures, Usage

PROVEN = "proven"
"""The key under which a motion says what is proven of it."""
INTERPOLATION = "interpolation"
"""The key under which it says what a controller makes of its rows."""
ROW_LIMIT = 1.001
"""Part of a limit from which on a controller's own interpolation of the rows is warned of."""


def trajectory_section(figures: "TrajectoryFigures") -> Section:
    """Give the duration, how close it is to the shortest possible one, and the largest fraction of each limit.

    `usage` has a number per actuator (link forces: per link; TCP: one), `peak` the largest magnitudes in SI units,
    limited or not; "skipped" means that there is no limit, or that forces need masses, which are not given.
    """
    usage = figures.usage
    section = {
        "status": "done",
        "duration_s": figures.duration_s,
        "period_s": figures.period_s,
        "samples": figures.samples,
        "dwell_s": figures.dwell_s,
        "usage": _usage(usage),
        "peak": {quantity.name: usage.peaks.get(quantity.name, SKIPPED) for quantity in usage.quantities},
    }
    if (timing := figures.timing) is not None:
        section |= {
            "jerk": "limited" if timing.jerk_limited else "not limited",
            "motion_s": timing.motion_s,
            **_against_bound(timing),
            "jerk_pieces": timing.pieces,
            "jerk_rounds": timing.rounds,
            "jerk_iterations": timing.iterations,
        }
    return section


def quality_part(quality: "MotionQuality") -> Section:
    """Give what timing knows of the motion's quality, per actuator; `summary.whole` puts it into the path's part."""
    return {
        QUALITY: {
            "velocity_sign_changes": list(quality.velocity_sign_changes),
            "acceleration_sign_changes": list(quality.acceleration_sign_changes),
            "motion_s": quality.motion_s,
            "least_times_s": list(quality.least_times_s),
            "time_ratio": quality.time_ratio,
        }
    }


def _against_bound(timing: "TimingReport") -> Section:
    """Give what planning without jerk limits found; nothing for a path that came with a time law."""
    if timing.grid_points == 0:
        return {}
    return {
        "duration_without_jerk_s": timing.fastest_s,
        "duration_bound_s": timing.bound_s,
        "gap": timing.gap,
        "jerk_cost": timing.jerk_cost,
        "grid_points": timing.grid_points,
    }


def proven_part(proof: "MotionProof") -> Section:
    """Give what is proven of the motion for every instant, and what it is proven of."""
    jumps = dict(zip(("position_m", "velocity_mps", "acceleration_mps2"), proof.jumps.largest.tolist(), strict=True))
    return {
        PROVEN: {
            **proof.fractions,
            **({"peak": dict(proof.peaks)} if proof.peaks else {}),
            "intervals": proof.intervals,
            "jumps": jumps if proof.jerk_limited else {key: jumps[key] for key in list(jumps)[:2]},
            "law_sha256": proof.law_sha256,
        }
    }


def interpolation_section(interpolated: "Iterable[Interpolation]") -> Section:
    """Give what a controller makes of the rows, by interpolation and per actuator: the sidecar has the same."""
    return {
        one.method: {
            "deviation_m": one.deviation_m.tolist(),
            "usage": {name: part.tolist() for name, part in one.usage.items()},
            "jump": {one.jump[0]: one.jump[1].tolist()},
        }
        for one in interpolated
    }


def back_section(figures: "TrajectoryFigures") -> Section:
    """Give the duration of the way back, and the largest fraction of each limit."""
    return {
        "status": "done",
        "duration_s": figures.duration_s,
        "samples": figures.samples,
        "usage": _usage(figures.usage),
    }


def trajectory_words(section: Section) -> str:
    """Say the key figures in words."""
    used = {name: max(values) for name, values in section["usage"].items() if not isinstance(values, str)}
    parts = ", ".join(f"{share:.0%} of {name.replace('_', ' ').replace('tcp', 'TCP')}" for name, share in used.items())
    words = f"{section['duration_s']:.2f} s, {section['samples']:,} rows {section['period_s']:g} s apart; up to {parts}"
    if PROVEN in section:
        names = [name.replace("_", " ").replace("tcp", "TCP") for name in used if name in section[PROVEN]]
        words += f"; {', '.join(names)} proven at every instant"
    if beyond := [_row_words(method, one["usage"]) for method, one in section.get(INTERPOLATION, {}).items()]:
        words += "".join(beyond)
    if "gap" in section:
        words += f"; {section['jerk_cost']:+.1%} for jerk, {section['gap']:.2%} above the bound without"
    if failed_part(section):
        words += "; the way back failed"
    return words


def _row_words(method: str, usage: Section) -> str:
    """Say which limit a controller's own interpolation of the rows exceeds most, if any."""
    name = max(usage, key=lambda name: max(usage[name]))
    largest = max(usage[name])
    return f"; rows read by {method} interpolation take {largest:.1%} of {name}" if largest > ROW_LIMIT else ""


def _usage(usage: "Usage") -> Section:
    return {quantity.name: usage.fractions.get(quantity.name, SKIPPED) for quantity in usage.quantities}
