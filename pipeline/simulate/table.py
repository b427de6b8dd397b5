"""A simulated motion as text, JSON and columns."""

from collections.abc import Sequence
from dataclasses import asdict
from typing import Any, NamedTuple

import numpy as np

from pipeline.arrays import FloatArray
from pipeline.export.trajectory_columns import POSE
from pipeline.machine.geometry import ACTUATORS, LINKS
from pipeline.measured.comparison import COORDINATES
from pipeline.measured.table import TIME
from pipeline.simulate.result import Simulation
from pipeline.simulate.rows import determinant, drive_rows, link_rows, mode_rows, pose_rows, tcp_error
from pipeline.simulate.tube import TubeCheck


class TextTable(NamedTuple):
    """A table of text: its title, headings and rows; the first `words` columns are words, all others numbers."""

    title: str
    header: tuple[str, ...]
    rows: Sequence[tuple[str, ...]]
    words: int


def simulation_columns(simulation: Simulation) -> dict[str, FloatArray]:
    """Name the columns of a simulated motion: time and pose as `measured` reads them, and what the machine did.

    `e` are following errors (commanded - real), `f` forces of the drives, `link` forces along the links.
    """
    numbers = range(1, len(ACTUATORS) + 1)
    groups = (
        (POSE, simulation.pose),
        ([f"q{k}_m" for k in numbers], simulation.q_m),
        ([f"qd{k}_mps" for k in numbers], simulation.qd_mps),
        ([f"qdd{k}_mps2" for k in numbers], simulation.qdd_mps2),
        ([f"e{k}_m" for k in numbers], simulation.following_error_m),
        ([f"f{k}_n" for k in numbers], simulation.drive_n),
        ([f"link_{link}_n" for link in LINKS], simulation.link_n),
    )
    named = {name: values[:, k] for names, values in groups for k, name in enumerate(names)}
    return {TIME: simulation.t_s, **named}


def simulation_data(simulation: Simulation, checks: Sequence[TubeCheck] = ()) -> dict[str, Any]:
    """Sum up a simulated motion, and how it keeps its proven tubes if there are any, as plain data in SI units."""
    units = {"rx": "rad", "rz": "rad"}
    errors = [{**asdict(row), "unit": units.get(row.quantity, "m")} for row in pose_rows(simulation)]
    return {
        "verdict": asdict(simulation.verdict),
        "period_s": simulation.motion.period_s,
        "duration_s": float(simulation.motion.t_s[-1]),
        "errors": [{key: value for key, value in row.items() if value is not None} for row in errors],
        "tcp_error": asdict(tcp_error(simulation)),
        "drives": [asdict(row) for row in drive_rows(simulation)],
        "links": [asdict(row) for row in link_rows(simulation)],
        "modes": [asdict(row) for row in mode_rows(simulation)],
        "det_h": asdict(determinant(simulation)),
        "tubes": [_tube_data(simulation, check) for check in checks],
        "simulated_s": simulation.simulated_s,
        "seconds": simulation.seconds,
    }


def simulation_tables(simulation: Simulation) -> list[TextTable]:
    """Make tables of errors, drives, links and working modes, in millimetres and degrees."""
    return [_errors(simulation), _drives(simulation), _links(simulation), _modes(simulation)]


def determinant_text(simulation: Simulation) -> str:
    """Say in a sentence how det H compares with the plan."""
    found = determinant(simulation)
    sign = "keeps its sign" if found.sign_kept else "changes its sign"
    return f"det H {sign}; at least {found.least_ratio:.4f} of the planned one, at {found.least_ratio_at_s:.3f} s"


def tube_table(simulation: Simulation, check: TubeCheck) -> TextTable:
    """Make a table of the largest contour error of each drive against what is proven, in millimetres."""
    off = np.abs(check.contour_error_m)
    rows = [
        (
            name,
            f"{1e3 * check.contour_error_m[row, k]:+.3f}",
            f"{simulation.t_s[row]:.3f}",
            f"{1e3 * check.tube.errors_m[k]:.4g}",
            f"{off[row, k] / check.tube.errors_m[k]:.1%}",
        )
        for k, (name, row) in enumerate(zip(ACTUATORS, off.argmax(axis=0).tolist(), strict=True))
    ]
    header = ("drive", "contour error mm", "at s", "proven mm", "of proven")
    title = (
        "contour errors against the proven tube (from the one point of the path nearest for all drives together: a "
        "late telescope moves it, and carts are then off by more than their following errors)"
    )
    return TextTable(title, header, rows, 1)


def tube_text(simulation: Simulation, check: TubeCheck) -> str:
    """Say whether the motion stays within the proven tube and, if not, which trip limit would have said so."""
    worst, widest_mm = check.worst, 1e3 * check.tube.errors_m.min()
    share = f"{check.share[worst]:.1%} of it at {simulation.t_s[worst]:.3f} s"
    if check.inside:
        return f"within the proven tube of {widest_mm:.4g} mm, {share}: as configured, {check.tube.meaning}"
    left = float(simulation.t_s[np.argmax(check.share > 1.0)])
    text = f"NOT within the proven tube of {widest_mm:.4g} mm, from {left:.3f} s on, {share}: {check.tube.lost} there"
    if (tripped := trip_at(simulation, check)) is not None:
        text += f"; with following_error_trip_m at {widest_mm:.4g} mm drives would have tripped at {tripped:.3f} s"
    return text


def trip_text(simulation: Simulation, checks: Sequence[TubeCheck]) -> str | None:
    """Say which drives would trip only outside of a proven tube, and what to set instead; None if none would."""
    trip_m = simulation.drives.trip_m
    passed = [(check.tube, trip_m > check.tube.errors_m) for check in checks]
    passed = [(tube, late) for tube, late in passed if late.any()]
    if not passed:
        return None
    late = np.any([late for _, late in passed], axis=0)
    drives = ", ".join(f"{ACTUATORS[k]} at {1e3 * trip_m[k]:.4g} mm" for k in np.flatnonzero(late))
    if late.all() and np.ptp(trip_m) == 0.0:
        drives = f"at {1e3 * trip_m[0]:.4g} mm"
    proven = " and ".join(f"{1e3 * tube.errors_m.min():.4g} mm ({tube.meaning})" for tube, _ in passed)
    return (
        f"these drives trip too late to stay in the proven tube: {drives}, beyond {proven}; set following_error_trip_m "
        "in drives below that, less what a drive moves off the path while it brakes, which is not known here"
    )


def trip_at(simulation: Simulation, check: TubeCheck) -> float | None:
    """Find when drives that trip at the proven errors would have tripped; None if they would not have."""
    beyond = (np.abs(simulation.following_error_m) > check.tube.errors_m).any(axis=1)
    return float(simulation.t_s[beyond.argmax()]) if beyond.any() else None


def _tube_data(simulation: Simulation, check: TubeCheck) -> dict[str, Any]:
    worst = check.worst
    return {
        "inside": check.inside,
        "errors_m": check.tube.errors_m.tolist(),
        "within_limits": check.tube.within_limits,
        "share": float(check.share[worst]),
        "share_at_s": float(simulation.t_s[worst]),
        "drive": ACTUATORS[int((np.abs(check.contour_error_m[worst]) / check.tube.errors_m).argmax())],
        "contour_error_m": np.abs(check.contour_error_m).max(axis=0).tolist(),
        "late_s": [float(check.late_s.min()), float(check.late_s.max())],
        "trip_at_s": trip_at(simulation, check),
        "trips_within": bool((simulation.drives.trip_m <= check.tube.errors_m).all()),
    }


def _errors(simulation: Simulation) -> TextTable:
    tcp = tcp_error(simulation)
    rows = [
        (
            row.quantity,
            shown.unit,
            f"{shown.scale * row.mean:+.4f}",
            f"{shown.scale * row.rms:.4f}",
            f"{shown.scale * row.largest:+.4f}",
            f"{row.largest_at_s:.3f}",
        )
        for row, shown in zip(pose_rows(simulation), COORDINATES, strict=True)
    ]
    whole = ("TCP", "mm", "", f"{1e3 * tcp.rms_m:.4f}", f"{1e3 * tcp.largest_m:.4f}", f"{tcp.largest_at_s:.3f}")
    header = ("quantity", "unit", "mean error", "rms error", "largest error", "at s")
    return TextTable("errors, simulated - commanded", header, [*rows, whole], 2)


def _drives(simulation: Simulation) -> TextTable:
    rows = [
        (
            row.drive,
            f"{1e3 * row.following_error_m:+.3f}",
            f"{row.following_error_at_s:.3f}",
            f"{row.trip_share:.1%}",
            f"{row.planned_peak_n:.1f}",
            f"{row.peak_n:.1f}",
            _share(row.force_share),
            f"{row.saturated_s:.3f}",
        )
        for row in drive_rows(simulation)
    ]
    header = ("drive", "following mm", "at s", "of trip", "planned N", "simulated N", "of limit", "saturated s")
    return TextTable("drives: largest following errors and forces", header, rows, 1)


def _links(simulation: Simulation) -> TextTable:
    rows = [
        (
            row.link,
            f"{row.planned_peak_n:.1f}",
            f"{row.peak_n:.1f}",
            f"{row.largest_difference_n:.1f}",
            _share(row.force_share),
        )
        for row in link_rows(simulation)
    ]
    header = ("link", "planned N", "simulated N", "difference N", "of limit")
    return TextTable("links: largest forces", header, rows, 1)


def _modes(simulation: Simulation) -> TextTable:
    rows = []
    for row in mode_rows(simulation):
        late = "-" if row.t_s is None or row.planned_t_s is None else f"{1e3 * (row.t_s - row.planned_t_s):+.0f}"
        rows.append((row.mode or "-", row.planned_mode or "-", _time(row.t_s), _time(row.planned_t_s), late))
    header = ("mode", "planned", "from s", "planned s", "later by ms")
    return TextTable("working modes", header, rows, 2)


def _share(share: float) -> str:
    return f"{share:.1%}" if np.isfinite(share) and share > 0.0 else "-"


def _time(t_s: float | None) -> str:
    return "-" if t_s is None else f"{t_s:.3f}"
