"""The key statements of a report: how the run ended, what is proven, how good it is, and how much of limits is used."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from pipeline.report.data import Mood, StageRow, UsedLimit, Verdict
from pipeline.report.wording import greek, per_cent, sentence
from pipeline.retime.quantities import quantity_named
from pipeline.stage import Stage
from pipeline.status import Status
from pipeline.summary.objective_words import route_quantity
from pipeline.summary.section import failed_part

CERTIFIED, SKIPPED = "certified", "skipped"
_ROUNDING = 1e-6
_NOT_RUN = "not run"
_FINDING = "- "
"""Begins a line of the reasons why there is no route that says what a change would do."""
_SHOWN = tuple(stage for stage in Stage if stage is not Stage.FIGURES)
"""The stages in the report, which is itself part of the last one."""


@dataclass(frozen=True)
class StageFacts:
    """How a stage ended: whether it failed, its part of the summary, hashes of its files by name, key figures in words.

    The page does not show seconds: the same results make the same report.
    """

    failed: bool
    section: Mapping[str, Any]
    files: Mapping[str, str] = field(default_factory=dict)
    words: str = ""


Facts = Mapping[Stage, StageFacts]


def headline(facts: Facts) -> Verdict:
    """State in one line what a reader can rely on."""
    topic = "Verdict"
    for stage in _SHOWN:
        if stage in facts and facts[stage].failed:
            if stage is Stage.CERTIFY:
                return Verdict(topic, "Not certified", "The proof failed: do not drive this path.", "bad")
            return Verdict(topic, f"Failed at {stage}", sentence(facts[stage].section.get("reason", "")), "bad")
    missing = [stage for stage in _SHOWN if stage not in facts]
    if missing:
        return Verdict(
            topic, "Not complete", f"{missing[0].capitalize()} and the stages after it have not run.", "open"
        )
    if (part := _failed_part(facts)) is not None:
        return Verdict(topic, "Done in part", sentence(part["reason"]), "bad")
    if _verdict(facts) != CERTIFIED:
        return Verdict(topic, "Not certified", "Checked at dense samples only: no proof was requested.", "open")
    return Verdict(topic, "Certified", "One motion, proven free of singularities and within every limit.", "good")


def verdicts(facts: Facts) -> tuple[Verdict, ...]:
    """Answer the questions of whoever decides on the motion."""
    statements = (
        (Stage.CERTIFY, _certificate),
        (Stage.ROUTE, _route),
        (Stage.REFINE, _path),
        (Stage.REFINE, _clearance),
        (Stage.RETIME, _duration),
        (Stage.RETIME, _limits),
        (Stage.CERTIFY, _tolerances),
    )
    done = [state(facts[stage].section) for stage, state in statements if stage in facts and not facts[stage].failed]
    return (_run(facts), *done)


def stage_rows(facts: Facts) -> tuple[StageRow, ...]:
    """Report how each stage ended; for a failed one, why and what to change."""
    return tuple(_stage_row(stage, facts.get(stage)) for stage in _SHOWN)


def used_limits(section: Mapping[str, Any]) -> tuple[UsedLimit, ...]:
    """Find, for each limited quantity, the subject that uses most of its limit."""
    used = []
    for name, parts in section.get("usage", {}).items():
        if not isinstance(parts, str):
            quantity = quantity_named(name)
            part, subject = max(zip(_numbers(parts), quantity.subjects, strict=True))
            used.append(UsedLimit(quantity.words, subject, part))
    return tuple(used)


def _numbers(parts: Sequence[float | None]) -> list[float]:
    """Convert fractions to numbers; a subject without a limit uses none of it."""
    return [0.0 if part is None else float(part) for part in parts]


def _stage_row(stage: Stage, facts: StageFacts | None) -> StageRow:
    if facts is None:
        return StageRow(stage, _NOT_RUN, "open", "")
    section = facts.section
    if facts.failed:
        reason, advice = str(section.get("reason", "")), str(section.get("advice", ""))
        lines = [str(line) for line in section.get("why_not", ())]
        remarks = tuple(line for line in lines if not line.startswith(_FINDING))
        findings = tuple(line.removeprefix(_FINDING) for line in lines if line.startswith(_FINDING))
        return StageRow(stage, "failed", "bad", sentence(reason), advice, remarks, findings)
    status = str(section["status"])
    if (part := failed_part(section)) is not None:
        words = f"{greek(facts.words)}. {sentence(part['reason'])}"
        return StageRow(stage, status, "bad", words, str(part["advice"]))
    mood: Mood = "open" if status == SKIPPED else "good"
    return StageRow(stage, status, mood, greek(facts.words))


def _failed_part(facts: Facts) -> Mapping[str, Any] | None:
    """Give the part that failed of a stage that has a result otherwise; None if there is none."""
    return next((part for one in facts.values() if (part := failed_part(one.section)) is not None), None)


def _verdict(facts: Facts) -> str:
    return str(facts[Stage.CERTIFY].section["verdict"]) if Stage.CERTIFY in facts else SKIPPED


def _run(facts: Facts) -> Verdict:
    failed = [stage for stage in _SHOWN if stage in facts and facts[stage].failed]
    if failed:
        return Verdict("Run", "Exit code 1", f"No result of {failed[0]}; earlier results are kept.", "bad")
    if _failed_part(facts) is not None:
        return Verdict("Run", "Exit code 1", "The way back failed; everything else is complete.", "bad")
    missing = [stage for stage in _SHOWN if stage not in facts]
    if missing:
        return Verdict("Run", "Not complete", f"Next is {missing[0]}.", "open")
    return Verdict("Run", "Exit code 0", "All stages done.", "good")


def _certificate(section: Mapping[str, Any]) -> Verdict:
    if section["verdict"] != CERTIFIED:
        return Verdict("Certificate", str(section["verdict"]).capitalize(), "No proof was requested.", "open")
    distances = {
        "link axes at least {:.1f} mm apart": section["min_distance_bound_m"],
        "bodies at least {:.1f} mm apart": section.get("min_body_distance_bound_m"),
        "obstacles at least {:.1f} mm away": section.get("min_obstacle_distance_bound_m"),
    }
    apart = "".join(f"; {text.format(1e3 * least)}" for text, least in distances.items() if least is not None)
    detail = f"{section['boxes']:,} boxes: κ at most {section['kappa_bound']:.2f}{apart}."
    if (avoided := section.get("avoided_by_bound")) is not None:
        detail += f" Boxes to avoid at least {1e3 * avoided:.1f} mm or mrad away."
    if (least := section.get("least_kappa")) is not None:
        detail += f" No path within the limits can do with less than {least:.2f}."
    return Verdict("Certificate", "Certified", detail, "good")


def _route(section: Mapping[str, Any]) -> Verdict:
    quantity = route_quantity(section)
    detail = (
        f"Gap {per_cent(section['gap'], 2)}; {section['steps']} positions, {section['mode_changes']} changes of "
        f"working mode, {greek(quantity.name)} {quantity.shown(section['objective'])}."
    )
    mood: Mood = "good" if section["status"] == Status.OPTIMAL else "open"
    return Verdict("Route", str(section["status"]).capitalize(), detail, mood)


def _path(section: Mapping[str, Any]) -> Verdict:
    coarse, refined = section["coarse_kappa_integral"], section["kappa_integral"]
    change = per_cent(refined / coarse - 1.0, 1, sign="+")
    detail = f"Integral of κ {refined:.1f} instead of {coarse:.1f}; largest κ {section['kappa_max']:.1f}."
    return Verdict("Path", change, detail, "good" if refined <= coarse else "open")


def _clearance(section: Mapping[str, Any]) -> Verdict:
    bodies = section.get("min_body_distance_m")
    distance, what = (section["min_link_distance_m"], "link axes") if bodies is None else (bodies, "bodies")
    detail = f"Smallest distance between {what}; largest tilt {section['max_tilt_deg']:.1f}°."
    return Verdict("Clearance", f"{1e3 * distance:.1f} mm", detail, "good")


def _duration(section: Mapping[str, Any]) -> Verdict:
    detail = f"{section['samples']:,} rows, one every {1e3 * section['period_s']:g} ms."
    if "gap" in section:
        gap, cost = per_cent(section["gap"], 2), per_cent(section["jerk_cost"], 1)
        detail += f" Within {gap} of the lower bound without jerk limits; these add {cost}."
    return Verdict("Duration", f"{section['duration_s']:.2f} s", detail, "good")


def _limits(section: Mapping[str, Any]) -> Verdict:
    used = used_limits(section)
    if not used:
        return Verdict("Limits", "None", "Nothing in motion has a limit.", "open")
    most = max(used, key=lambda one: one.part)
    kept = most.part <= 1.0 + _ROUNDING
    where = "Closest on the way there" if failed_part(section) else "Closest"
    detail = f"{where}: {most.kind} of {most.subject}, at {per_cent(most.part, 1)} of its limit."
    return Verdict("Limits", "Kept" if kept else "Exceeded", detail, "good" if kept else "bad")


def _tolerances(section: Mapping[str, Any]) -> Verdict:
    lengths, coordinates = section.get("tolerance_m"), section.get("coordinates_tolerance_m")
    if lengths is None or coordinates is None:
        return Verdict(
            "Calibration",
            "Not searched",
            "gantry-tau certify CONFIG --tolerance finds the geometric errors that the proof tolerates.",
            "open",
        )
    detail = f"Also proven if link lengths are off by this much, or every coordinate by ±{1e3 * coordinates:.3f} mm."
    return Verdict("Calibration", f"±{1e3 * lengths:.2f} mm", detail, "good")
