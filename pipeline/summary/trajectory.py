"""The trajectory in the summary."""

from typing import TYPE_CHECKING

from pipeline.summary.section import SKIPPED, Section, failed_part

if TYPE_CHECKING:
    from pipeline.retime import TrajectoryFigures, Usage


def trajectory_section(figures: "TrajectoryFigures") -> Section:
    """Give the duration, how close it is to the shortest possible one, and the largest fraction of each limit.

    `usage` has a number per actuator (link forces: per link; TCP: one), `peak` the largest magnitudes in SI units,
    limited or not; "skipped" means that there is no limit, or that forces need masses, which are not given.
    """
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
    if "gap" in section:
        words += f"; {section['jerk_cost']:+.1%} for jerk, {section['gap']:.2%} above the bound without"
    if failed_part(section):
        words += "; the way back failed"
    return words


def _usage(usage: "Usage") -> Section:
    from pipeline.retime.quantities import KINDS

    values = {kind.name: getattr(usage, kind.name) for kind in KINDS}
    return {name: SKIPPED if value is None else value for name, value in values.items()}
