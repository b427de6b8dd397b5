"""Cams for CODESYS SoftMotion, one per axis over a virtual time axis: points (X, Y, V, A), as an IEC declaration.

`MC_CAM_REF` of type 3 (XYVA) takes an array of `SMC_CAMXYVA`: master position, slave position, velocity and
acceleration; between two points it is the polynomial of degree five that has all six values. Here the master is the
time in seconds. Rows that these polynomials give to the tolerance anyway are left out, for each axis by itself.
"""

import re
from typing import Any

import numpy as np

from pipeline.arrays import FloatArray, IntArray
from pipeline.errors import UsageError
from pipeline.export.csv import DECIMALS
from pipeline.export.formats import LengthUnit
from pipeline.export.motion import Motion
from pipeline.export.request import ExportRequest

_MOST_POINTS = 32_767
"""`nElements` of `MC_CAM_REF` is an INT."""
_HEAD = re.compile(r"\(\* (\d+) rows, (\S+) s apart; (metres|millimetres)")
_UNITS = {LengthUnit.M: "metres", LengthUnit.MM: "millimetres"}
_CAM = re.compile(r"(\w+)_points: ARRAY\[0\.\.\d+\] OF SMC_CAMXYVA := \[(.*?)\];", re.DOTALL)
_POINT = re.compile(r"dX := (\S+), dY := (\S+), dV := (\S+), dA := ([^)\s]+)\)")


def format_cam(request: ExportRequest) -> str:
    """Write the declarations, with the largest error of each cam.

    Raises
    ------
    UsageError
        When names of joints make no different IEC identifiers, or a cam has more points than CODESYS takes.
    """
    samples, options = request.samples, request.options
    parts = [
        f"(* {len(samples)} rows, {samples.period_s!r} s apart; {_UNITS[options.length]}; the master is the time in s.",
        f"   Points left out are met within {options.tolerance_m:g} m; the largest error is with each cam. *)",
        "{attribute 'linkalways'}",
        "VAR_GLOBAL",
    ]
    decimals = max(DECIMALS, request.needed_decimals(options.length.metres))
    for k, name in enumerate(_identifiers(request)):
        axis = np.stack([samples.q_m[:, k], samples.qd_mps[:, k], samples.qdd_mps2[:, k]], axis=1)
        rows = thinned(samples.t_s, axis, options.tolerance_m)
        if len(rows) > _MOST_POINTS:
            raise UsageError(
                f"{request.joint_names[k]} takes {len(rows):,} points; MC_CAM_REF has at most {_MOST_POINTS:,}.\n"
                "  What to change: raise --tolerance or --period."
            )
        off = np.abs(hermite(samples.t_s[rows], axis[rows], samples.t_s)[:, :3] - axis).max(axis=0)
        values = np.column_stack([samples.t_s, axis / options.length.metres])[rows] + 0.0
        points = ",\n".join("    (" + _point(row, decimals) + ")" for row in values.tolist())
        parts += [
            f"  (* {request.joint_names[k]}: {len(rows)} points, off by at most {off[0]:.1e} m, {off[2]:.1e} m/s2 *)",
            f"  {name}_points: ARRAY[0..{len(rows) - 1}] OF SMC_CAMXYVA := [",
            points + "];",
            f"  {name}: MC_CAM_REF := (nElements := {len(rows)}, byType := 3, xStart := 0.0, "
            f"xEnd := {samples.duration_s:.{decimals}f}, nTappets := 0, strCAMName := '{name}', "
            f"pce := ADR({name}_points), xPartofLM := TRUE);",
        ]
    return "\n".join([*parts, "END_VAR"]) + "\n"


def _point(row: list[float], decimals: int) -> str:
    named = zip(("dX", "dY", "dV", "dA"), row, strict=True)
    return ", ".join(f"{name} := {value:.{decimals}f}" for name, value in named)


def _identifiers(request: ExportRequest) -> list[str]:
    names = [re.sub(r"_+", "_", "Cam_" + re.sub(r"\W", "_", joint)).rstrip("_") for joint in request.joint_names]
    if len({name.lower() for name in names}) < len(names):
        raise UsageError(
            f"as IEC identifiers two joints are called the same: {', '.join(names)}.\n"
            "  What to change: export.joint_names that differ in more than punctuation and case."
        )
    return names


def thinned(t_s: FloatArray, axis: FloatArray, tolerance: float) -> IntArray:
    """Choose the rows (m,) of an axis (n, 3) whose polynomials give all its positions to the tolerance.

    From each chosen row the next one is searched by doubling and halving the distance; first and last row are chosen.
    """
    rows, last = [0], len(t_s) - 1
    while rows[-1] < last:
        good, bad = 1, 2
        while rows[-1] + bad <= last and _fits(t_s, axis, rows[-1], rows[-1] + bad, tolerance):
            good, bad = bad, 2 * bad
        bad = min(bad, last - rows[-1] + 1)
        while bad - good > 1:
            middle = (good + bad) // 2
            if _fits(t_s, axis, rows[-1], rows[-1] + middle, tolerance):
                good = middle
            else:
                bad = middle
        rows.append(rows[-1] + good)
    return np.array(rows)


def _fits(t_s: FloatArray, axis: FloatArray, first: int, last: int, tolerance: float) -> bool:
    h, between = float(t_s[last] - t_s[first]), slice(first + 1, last)
    c0, c1, c2, c3, c4, c5 = _coefficients(h, axis[first].tolist(), axis[last].tolist())
    u = (t_s[between] - t_s[first]) / h
    found = c0 + u * (c1 + u * (c2 + u * (c3 + u * (c4 + u * c5))))
    return bool((np.abs(found - axis[between, 0]) <= tolerance).all())


def _coefficients(h: Any, start: Any, end: Any) -> tuple[Any, ...]:
    """Compute the six coefficients in u = t / h between position, velocity and acceleration at 0 and h.

    For numbers, or for arrays of one shape.
    """
    (p0, v0, a0), (p1, v1, a1) = start, end
    rise, v0, v1, a0, a1 = p1 - p0, v0 * h, v1 * h, a0 * h**2, a1 * h**2
    return (
        p0,
        v0,
        a0 / 2.0,
        10.0 * rise - 6.0 * v0 - 4.0 * v1 - 1.5 * a0 + 0.5 * a1,
        -15.0 * rise + 8.0 * v0 + 7.0 * v1 + 1.5 * a0 - a1,
        6.0 * rise - 3.0 * v0 - 3.0 * v1 - 0.5 * a0 + 0.5 * a1,
    )


def hermite(t_s: FloatArray, points: FloatArray, at_s: FloatArray) -> FloatArray:
    """Evaluate the polynomials of degree five through points (m, 3) of position, velocity, acceleration at t (m,).

    Returns position, velocity, acceleration and jerk at times (n,). Shape (n, 4).
    """
    k = np.clip(np.searchsorted(t_s, at_s, side="right") - 1, 0, len(t_s) - 2)
    h = t_s[k + 1] - t_s[k]
    u = (at_s - t_s[k]) / h
    c0, c1, c2, c3, c4, c5 = _coefficients(h, points[k].T, points[k + 1].T)
    return np.stack(
        [
            c0 + u * (c1 + u * (c2 + u * (c3 + u * (c4 + u * c5)))),
            (c1 + u * (2.0 * c2 + u * (3.0 * c3 + u * (4.0 * c4 + u * 5.0 * c5)))) / h,
            (2.0 * c2 + u * (6.0 * c3 + u * (12.0 * c4 + u * 20.0 * c5))) / h**2,
            (6.0 * c3 + u * (24.0 * c4 + u * 60.0 * c5)) / h**3,
        ],
        axis=1,
    )


def read_cam(text: str) -> Motion:
    """Read the cams back: the motion at all rows that they were made from, by the polynomials between their points.

    Raises
    ------
    ValueError
        When the text has no cams, or does not say what rows they stand for.
    """
    head, cams = _HEAD.match(text), _CAM.findall(text)
    if head is None or not cams:
        raise ValueError("not a declaration of cams with their rows")
    unit = LengthUnit.MM.metres if head[3] == _UNITS[LengthUnit.MM] else 1.0
    t = float(head[2]) * np.arange(int(head[1]), dtype=float)
    axes = []
    for _, points in cams:
        table = np.array([[float(value) for value in point] for point in _POINT.findall(points)])
        axes.append(hermite(table[:, 0], unit * table[:, 1:], t)[:, :3])
    q, qd, qdd = np.stack(axes, axis=2).swapaxes(0, 1)
    return Motion(t, q, qd, qdd)
