"""The files of a tour: one motion for the controller, the poses to be filled in, and what is proven of every leg."""

from itertools import pairwise
from typing import Any

import numpy as np

from pipeline.arrays import FloatArray
from pipeline.artifacts import json_bytes
from pipeline.artifacts.layout import TOUR_CSV, TOUR_JSON, TOUR_POSES, TRAJECTORY_CSV
from pipeline.config import Config
from pipeline.config.file import config_sha256
from pipeline.export.csv import format_csv, read_csv
from pipeline.export.trajectory_columns import POSE, POSITIONS
from pipeline.run.tour.legs import Leg
from pipeline.run.tour.result import Tour
from pipeline.run.tour.stops import StopTable


def tour_files(config: Config, table: StopTable, tour: Tour, dwell_s: float) -> dict[str, bytes]:
    """Make the files of a tour from the trajectories of its legs, in the units of the controller."""
    texts = [(leg.run / TRAJECTORY_CSV).read_text() for leg in tour.legs]
    rows = [_rows(text) for text in texts]
    ends = np.cumsum([part[-1, 0] for part in rows])
    jumps = [float(np.abs(after[0, 1:6] - before[-1, 1:6]).max()) for before, after in pairwise(rows)]
    legs = [
        _leg_data(tour, leg, (float(end - part[-1, 0]), float(end)), dwell_s)
        for leg, part, end in zip(tour.legs, rows, ends, strict=True)
    ]
    data = {
        "config_sha256": config_sha256(config),
        "dwell_s": dwell_s,
        "duration_s": float(ends[-1]),
        "poses": len(tour.visits),
        "largest_jump_m": max(jumps, default=0.0),
        "legs": legs,
        "left_out": [{"pose": name, "reason": reason} for name, reason in tour.left_out.items()],
        "no_return": tour.no_return or None,
    }
    return {
        TOUR_CSV: joined(texts, ends).encode(),
        TOUR_POSES: _poses(table, tour, rows, ends, dwell_s).encode(),
        TOUR_JSON: json_bytes(data),
    }


def joined(texts: list[str], ends_s: FloatArray) -> str:
    """Join tables of motions, each of which begins where the one before ends, with its time going on."""
    lines = texts[0].splitlines()
    decimals = len(lines[-1].partition(",")[0].partition(".")[2])
    for text, begin in zip(texts[1:], ends_s[:-1], strict=True):
        # The first row of a motion is the last one of the motion before.
        for line in text.splitlines()[2:]:
            t, _, rest = line.partition(",")
            lines.append(f"{begin + float(t):.{decimals}f},{rest}")
    return "\n".join(lines) + "\n"


def _rows(text: str) -> FloatArray:
    """Read t_s, positions and pose of a motion. Shape (n, 12)."""
    columns = read_csv(text)
    return np.column_stack([columns[name] for name in ("t_s", *POSITIONS, *POSE)])


def _leg_data(tour: Tour, leg: Leg, times_s: tuple[float, float], dwell_s: float) -> dict[str, Any]:
    path, certificate = leg.summary["path"], leg.summary["certificate"]
    origin, target = (tour.stations[k] for k in (leg.origin, leg.target))
    return {
        "from": origin.name,
        "to": target.name,
        "mode": target.pose.mode,
        "place": target.key,
        "run": f"{leg.run.parent.name}/{leg.run.name}",
        "route": leg.summary["route"]["status"],
        "verdict": certificate["verdict"],
        "kappa_max": path["kappa_max"],
        "kappa_bound": certificate.get("kappa_bound"),
        "begin_s": times_s[0],
        "arrives_s": times_s[1] - (dwell_s if leg.target else 0.0),
        "end_s": times_s[1],
    }


def _poses(table: StopTable, tour: Tour, rows: list[FloatArray], ends_s: FloatArray, dwell_s: float) -> str:
    """Write the poses in the order of the tour, with blanks for what is measured, and when the machine stands there."""
    visits = [k for k, leg in enumerate(tour.legs) if leg.target]
    last = np.array([rows[k][-1] for k in visits])
    columns: dict[str, Any] = dict(zip(POSITIONS, last[:, 1:6].T, strict=True))
    columns |= {name: np.full(len(visits), "") for name in table.blanks}
    columns |= dict(zip(POSE, last[:, 6:].T, strict=True))
    stations = [tour.stations[tour.legs[k].target] for k in visits]
    columns |= {
        "mode": np.array([station.pose.mode for station in stations]),
        "pose": np.array([station.name for station in stations]),
        "from_s": ends_s[visits] - dwell_s,
        "to_s": ends_s[visits],
    }
    return format_csv(columns)
