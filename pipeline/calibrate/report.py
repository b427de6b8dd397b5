"""A calibration as text and as plain data: every parameter, errors, and what the convention of gauges is."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from pipeline.calibrate.calibration import Calibration, Check
from pipeline.calibrate.data.reading import PosesFile, reflector_columns
from pipeline.calibrate.model.parameters import CLOCKS
from pipeline.calibrate.next_poses import NextPoses
from pipeline.calibrate.verdict import Verdict, measured_modes
from pipeline.config.file import config_sha256
from pipeline.export.trajectory_columns import POSE, POSITIONS

FROM_DATA, FROM_PRIOR, NOT_FITTED = "from the data", "from the prior", "not fitted"
ERROR_HEADER = ("poses", "points", "outliers", "configured mm", "calibrated mm", "predicted mm")
GAUGES = (
    "Changes of the machine that change nothing that is seen are settled by what was known beforehand: rails, zeros of "
    "carts and offsets of their joints share what only their sum says; the frames of machine and platform are those of "
    "the configuration and of the reflectors. Deviations of single parameters contain this freedom."
)
NEXT_HEADER = ("pose", "mode", "x m", "y m", "z m", "rx deg", "rz deg", "kappa", "error then mm")
_FAR_WORSE = 10.0
_UNKNOWN_M = 0.1
"""Predicted errors above it only say that the tracker's frame is not known yet."""
_MILLIONTHS = {"m": "um", "1": "ppm", "rad": "urad"}
"""Units of parameters, and what changes of them are told in."""
_TITLES = {"m": "lengths", "1": "scales", "rad": "angles"}


def sources(calibration: Calibration) -> list[str]:
    """Say of every parameter where its value is from: the data, where they halve the variance that was known."""
    found = calibration.identification
    told = found.std**2 <= 0.5 * found.problem.prior_std**2
    return [
        NOT_FITTED if not fitted else FROM_DATA if known else FROM_PRIOR
        for fitted, known in zip(found.problem.is_fitted, told, strict=True)
    ]


def error_cells(calibration: Calibration) -> list[tuple[str, ...]]:
    """Format the errors of fitted poses and of those held out, under `ERROR_HEADER`: rms distances of points."""
    rows = [_error_row("fitted", calibration.fitted)]
    if calibration.held_out is not None:
        rows.append(_error_row("held out", calibration.held_out))
    return rows


def _error_row(name: str, check: Check) -> tuple[str, ...]:
    millimetres = (f"{1e3 * value:.4f}" for value in (check.before_m, check.after_m, check.predicted_m))
    return (name, f"{check.points:,}", f"{check.rejected:,}", *millimetres)


@dataclass(frozen=True)
class ParameterTable:
    """Fitted parameters of one unit as text: a row each, with the units in the header."""

    title: str
    header: tuple[str, ...]
    rows: list[tuple[str, ...]]


def parameter_tables(calibration: Calibration) -> list[ParameterTable]:
    """Format the parameters that were fitted, but frame and clocks of the tracker: a table per unit that there is."""
    found = calibration.identification
    parameters, configured, origins = found.model.parameters, found.problem.model.values(), sources(calibration)
    rows: dict[str, list[tuple[str, ...]]] = {unit: [] for unit in _MILLIONTHS}
    for k, name in enumerate(parameters.names[: parameters.slice(CLOCKS).start]):
        if found.problem.is_fitted[k]:
            deviations = (f"{1e6 * value:.1f}" for value in (found.std[k], found.problem.prior_std[k]))
            change = f"{1e6 * found.theta[k]:+.1f}"
            rows[parameters.units[k]].append((name, f"{configured[k]:.6f}", change, *deviations, origins[k]))
    return [ParameterTable(_TITLES[unit], _parameter_header(unit), cells) for unit, cells in rows.items() if cells]


def motion_words(calibration: Calibration) -> list[str]:
    """Say what motions tell: by how much clocks are late, and how sure the machine is along them, and elsewhere."""
    found, reach = calibration.identification, calibration.reach
    if reach is None:
        return []
    std = found.model.parameters.of(CLOCKS, found.std)
    said = [
        f"motion {number}: the clock of the tracker is late by {1e3 * late:+.4f} ms, within {1e3 * deviation:.4f} ms"
        if deviation > 0.0
        else f"motion {number}: the clocks were taken to agree, since --fit leaves clocks out"
        for number, (late, deviation) in enumerate(zip(found.model.clocks_s, std, strict=True), 1)
    ]
    along, elsewhere = 1e3 * reach.along_m, 1e3 * reach.elsewhere_m
    said.append(f"predicted error of a reflector: {along:.3f} mm along the motions, {elsewhere:.3f} mm elsewhere")
    if elsewhere > _FAR_WORSE * along:
        said.append("Good along the motions, and no calibration of the machine: for that, add static poses elsewhere.")
    return said


def _motion_data(calibration: Calibration) -> dict[str, Any]:
    found, reach = calibration.identification, calibration.reach
    if reach is None:
        return {}
    std = found.model.parameters.of(CLOCKS, found.std).tolist()
    return {
        "clocks": [
            {"late_s": late, "std_s": deviation}
            for late, deviation in zip(found.model.clocks_s.tolist(), std, strict=True)
        ],
        "predicted_m": {"along_motions": reach.along_m, "elsewhere": reach.elsewhere_m},
    }


def _parameter_header(unit: str) -> tuple[str, ...]:
    configured = "configured" if unit == "1" else f"configured {unit}"
    return (
        "parameter",
        configured,
        *(f"{what} {_MILLIONTHS[unit]}" for what in ("change", "deviation", "known to")),
        "",
    )


def calibration_data(calibration: Calibration, verdict: Verdict, files: Sequence[PosesFile] = ()) -> dict[str, Any]:
    """Give all of a calibration as plain data, in SI units."""
    found, setting = calibration.identification, calibration.setting
    problem, parameters = found.problem, found.model.parameters
    rows = zip(
        *(parameters.names, parameters.units, problem.model.values(), found.theta, found.std, problem.prior_std),
        sources(calibration),
        strict=True,
    )
    keys = ("name", "unit", "configured", "change", "std", "prior_std", "source")
    return {
        "config_sha256": config_sha256(calibration.config),
        "files": [{"file": one.account.file, "sha256": one.sha256, **one.account.as_json()} for one in files],
        "setting": {
            "noise_m": setting.noise_m,
            "fit": list(setting.fit),
            "prior": dict(setting.prior),
            "robust": setting.robust,
            "hold_out": setting.hold_out,
            "reflectors_m": problem.model.reflectors_m,
        },
        "accepted": verdict.accepted,
        "reasons": list(verdict.reasons),
        "chi2": verdict.chi2,
        "degrees_of_freedom": verdict.freedom,
        "probability": verdict.probability,
        "directions": {
            "fitted": verdict.directions,
            "gauges": verdict.gauges,
            "seen": verdict.rank,
            "from_data": verdict.from_data,
            "singular_values": np.linalg.svd(found.jacobian, compute_uv=False),
        },
        "gauge_convention": GAUGES,
        "errors": {"fitted": _check_data(calibration.fitted), "held_out": _check_data(calibration.held_out)},
        **_motion_data(calibration),
        "poses": len(problem.poses),
        "modes": measured_modes(found),
        "rejected": [
            {"place": problem.poses.place(int(row)), "reflector": int(reflector) + 1}
            for row, reflector in np.argwhere(calibration.rejected)
        ],
        "tracker": {"rotation": found.model.rotation, "translation_m": found.model.translation_m},
        "evaluations": found.evaluations,
        "parameters": [dict(zip(keys, row, strict=True)) for row in rows],
        "covariance": found.covariance,
    }


def _check_data(check: Check | None) -> dict[str, Any] | None:
    if check is None:
        return None
    names = ("points", "rejected", "before_m", "after_m", "predicted_m")
    return {name: getattr(check, name) for name in names}


def next_cells(poses: NextPoses) -> list[tuple[str, ...]]:
    """Format poses to measure next under `NEXT_HEADER`, with the predicted error anywhere once each is measured."""
    rows = zip(poses.modes, poses.pose, poses.kappa, poses.error_m[1:], strict=True)
    return [
        (
            f"{number}",
            mode,
            *(f"{value:.3f}" for value in pose[:3]),
            *(f"{value:+.1f}" for value in np.rad2deg(pose[[3, 5]])),
            f"{kappa:.1f}",
            f"{1e3 * error:.3f}" if error < _UNKNOWN_M else "-",
        )
        for number, (mode, pose, kappa, error) in enumerate(rows, 1)
    ]


def next_columns(poses: NextPoses, reflector_count: int) -> dict[str, Any]:
    """Name the columns of a table to be filled: encoders, reflectors yet unseen, and where the machine will be."""
    columns: dict[str, Any] = dict(zip(POSITIONS, poses.q_m.T, strict=True))
    unseen = np.full(len(poses.q_m), "")
    columns |= {name: unseen for number in range(reflector_count) for name in reflector_columns(number + 1)}
    return columns | dict(zip(POSE, poses.pose.T, strict=True)) | {"mode": np.array(poses.modes)}


def next_data(poses: NextPoses) -> dict[str, Any]:
    """Give poses to measure next as plain data, in SI units."""
    return {
        "q_m": poses.q_m,
        "pose": poses.pose,
        "mode": poses.modes,
        "kappa": poses.kappa,
        "error_m": [error if error < _UNKNOWN_M else None for error in poses.error_m.tolist()],
    }
