"""The route as files: `route.npz` to load it back, `route.csv` for people and programs."""

from dataclasses import fields

import numpy as np

from pipeline.artifacts.layout import ROUTE_CSV, ROUTE_NPZ
from pipeline.artifacts.npz import Arrays, npz_bytes, read_npz, readable
from pipeline.artifacts.results.columns import Q_COLUMNS, split_columns
from pipeline.artifacts.results.saved import SavedRun
from pipeline.export.csv import format_csv
from pipeline.export.trajectory_columns import POSE
from pipeline.route.result import Route, Search
from pipeline.status import Status


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
        **{f"search_{field.name}": getattr(route.search, field.name) for field in fields(Search)},
    }


def unpack_route(arrays: Arrays) -> Route:
    """Rebuild the route."""
    return Route(
        region=arrays["region"],
        modes=arrays["mode"],
        gates=arrays["gate"],
        visits=arrays["visit"],
        pose=arrays["pose"],
        q_m=arrays["q_m"],
        kappa=arrays["kappa"],
        objective=arrays["objective"].item(),
        status=Status(arrays["status"].item()),
        search=Search(**{field.name: arrays[f"search_{field.name}"].item() for field in fields(Search)}),
    )
