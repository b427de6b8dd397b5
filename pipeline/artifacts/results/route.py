"""The route as files: `route.npz` to load it back, `route.csv` for people and programs."""

from collections.abc import Callable
from dataclasses import fields
from typing import Any, get_type_hints

import numpy as np

from pipeline.artifacts.checked import CheckedArrays
from pipeline.artifacts.layout import ROUTE_CSV, ROUTE_NPZ
from pipeline.artifacts.npz import Arrays, npz_bytes, read_npz, readable
from pipeline.artifacts.results.columns import Q_COLUMNS, split_columns
from pipeline.artifacts.results.saved import SavedRun
from pipeline.config.choices import RouteObjective
from pipeline.export.csv import format_csv
from pipeline.export.trajectory_columns import POSE
from pipeline.machine.geometry import MODES
from pipeline.route.result import Route, Search
from pipeline.status import Status

_ARMS, _ENDS = 3, 2


def route_files(route: Route) -> dict[str, bytes]:
    """Write the route: one row per step as a table, and everything to load it back."""
    columns = {
        "step": np.arange(len(route)),
        "region": route.region,
        "mode": np.array(route.mode_names),
        **split_columns(POSE, route.pose),
        "kappa": route.kappa,
        **split_columns(Q_COLUMNS, route.q_m),
        "gate": route.gates,
    }
    return {ROUTE_NPZ: npz_bytes(pack_route(route)), ROUTE_CSV: format_csv(columns).encode()}


def load_route(run: SavedRun) -> Route:
    """Load the route of a run."""
    file = run.folder / ROUTE_NPZ
    with readable(file):
        return unpack_route(read_npz(file))


def pack_route(route: Route) -> dict[str, object]:
    """Give the arrays of the route, and how it was found as arrays without dimensions."""
    return {
        "region": route.region,
        "mode": route.modes,
        "gate": route.gates,
        "visit": route.visits,
        "pose": route.pose,
        "q_m": route.q_m,
        "kappa": route.kappa,
        "objective": route.objective,
        "status": str(route.status),
        "objective_kind": str(route.objective_kind),
        **{f"search_{field.name}": getattr(route.search, field.name) for field in fields(Search)},
    }


def unpack_route(arrays: Arrays) -> Route:
    """Rebuild the route.

    Raises
    ------
    ValueError
        When an array is missing, or is not one of a route.
    """
    checked = CheckedArrays(arrays)
    if len(checked.whole("region", "n")) < _ENDS:
        raise ValueError("it has no rows for start and goal")
    read: dict[type, Callable[[str], Any]] = {str: checked.text, int: checked.count, float: checked.number}
    return Route(
        region=checked.whole("region", "n"),
        modes=checked.whole("mode", "n", most=len(MODES) - 1),
        gates=checked.whole("gate", "n", most=_ARMS),
        visits=checked.whole("visit", "n"),
        pose=checked.floats("pose", "n", 6),
        q_m=checked.floats("q_m", "n", 5),
        kappa=checked.floats("kappa", "n"),
        objective=checked.number("objective"),
        status=Status(checked.text("status")),
        # Files of before there was a choice have none: theirs is the sum (5).
        objective_kind=RouteObjective(checked.text("objective_kind") if "objective_kind" in arrays else "sum"),
        search=Search(**{name: read[kind](f"search_{name}") for name, kind in get_type_hints(Search).items()}),
    )
