"""What is measured: the reference machine on finer and finer grids, and a ladder that starts small enough for all.

The ladder is for comparing methods: telescopes of any length, carts on their rails (0 to 2.1 m), a step
budget just above the fewest moves. Boxes smaller than the reference task's and lower limits on kappa make sizes.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from pipeline.config import Config
from pipeline.config.file import load_config, parse_config

CONFIGS = Path(__file__).parents[2] / "configs"
ANY_LENGTH_M = (0.01, 9.0)
LEVEL = (1.02, 1.02)
DETOUR = (1.4, 0.6)


@dataclass(frozen=True)
class Problem:
    """A configuration with a name for tables."""

    name: str
    config: Config


def scale_problems() -> list[Problem]:
    """The reference task on grids from coarse to fine, and at the size of the paper's program."""
    agder, paper = load_config(CONFIGS / "agder.yaml"), load_config(CONFIGS / "paper.yaml")
    return [
        Problem("0.1 m, 10°", _changed(agder, _grid(0.1, 10.0))),
        Problem("paper size", paper),
        Problem("0.1 m, 5°", _changed(agder, _grid(0.1, 5.0))),
        Problem("0.06 m, 5°", agder),
        # At this step no route has fewer than 27 positions.
        Problem("0.04 m, 5°", _changed(agder, _grid(0.04, 5.0) | {"step_budget": 40})),
    ]


_BOX = {"y_m": (0.3, 0.9), "z_m": (0.6, 1.2)}
_WIDE = {"y_m": (0.0, 1.2), "z_m": (0.3, 1.5)}


def ladder() -> list[Problem]:
    """Small problems to large ones; in those named "detour" x binds and makes the best route cost more."""
    return [
        _rung("0.3 m, 30°, kappa < 30", _grid(0.3, 30.0, **_BOX), 7, kappa_max=30.0),
        _rung("0.3 m, 30°", _grid(0.3, 30.0, **_BOX), 8),
        _rung("0.3 m, 30°, detour", _grid(0.3, 30.0, **_BOX), 10, x_m=DETOUR),
        _rung("0.2 m, 30°", _grid(0.2, 30.0, **_BOX), 10),
        _rung("0.2 m, 30°, detour", _grid(0.2, 30.0, **_BOX), 10, x_m=DETOUR),
        _rung("0.2 m, 30°, wide, kappa < 40", _grid(0.2, 30.0, **_WIDE), 10, kappa_max=40.0),
        _rung("0.2 m, 30°, wide, kappa < 60", _grid(0.2, 30.0, **_WIDE), 10, kappa_max=60.0),
        _rung("0.15 m, 30°", _grid(0.15, 30.0, **_BOX), 12),
        _rung("0.2 m, 30°, wide", _grid(0.2, 30.0, **_WIDE), 10),
        _rung("0.2 m, 15°, kappa < 40", _grid(0.2, 15.0, **_BOX), 11, kappa_max=40.0),
        _rung("0.15 m, 15°", _grid(0.15, 15.0, **_BOX), 11),
        _rung("0.1 m, 10°", _grid(0.1, 10.0, **_BOX), 14),
        _rung("0.1 m, 10°, all", _grid(0.1, 10.0), 14),
    ]


def _rung(
    name: str,
    grid: Mapping[str, Any],
    step_budget: int,
    kappa_max: float = 100.0,
    x_m: tuple[float, float] = LEVEL,
) -> Problem:
    options = {"step_budget": step_budget, "kappa_max": kappa_max}
    data = _changed(load_config(CONFIGS / "quick.yaml"), {**grid, **options}).model_dump()
    for link in ("l2b", "l3b"):
        data["machine"]["links"][link]["stroke_m"] = ANY_LENGTH_M
    data["task"]["start"]["x_m"], data["task"]["goal"]["x_m"] = x_m
    return Problem(name, parse_config(data))


def _changed(config: Config, route: Mapping[str, Any]) -> Config:
    """Ask for the sum (5), which the other solvers are given, too."""
    data = config.model_dump()
    data["route"].update(route, objective="sum")
    return parse_config(data)


def _grid(
    step_m: float,
    step_deg: float,
    y_m: tuple[float, float] = (-0.4, 1.2),
    z_m: tuple[float, float] = (0.1, 1.5),
) -> dict[str, Any]:
    axes = {name: {"min": low, "max": high, "step": step_m} for name, (low, high) in (("y_m", y_m), ("z_m", z_m))}
    return {"grid": {**axes, "rx_step_deg": step_deg, "rz_step_deg": step_deg}}


def finer_problems() -> list[Problem]:
    """The reference task on finer and finer grids of the same proportions, 100 degrees to the metre."""
    agder = load_config(CONFIGS / "agder.yaml")
    steps = (0.15, 0.1, 0.075, 0.06, 0.05)
    return [Problem(f"{step:g} m, {100 * step:g}°", _changed(agder, _grid(step, 100 * step))) for step in steps]


def level_problems() -> list[Problem]:
    """The 3-DOF machine, both tilts locked, on finer and finer grids; kappa, clearance and strokes stop nothing."""
    data = load_config(CONFIGS / "agder.yaml").model_dump()
    data["task"]["locked_axes"] = ["rx", "rz"]
    data["machine"]["clearance"] = {"link_link_m": 0.0, "link_rail_m": None}
    for link in ("l2b", "l3b"):
        data["machine"]["links"][link]["stroke_m"] = ANY_LENGTH_M
    level = parse_config(data)
    steps = (0.1, 0.05, 0.025, 0.0125, 0.00625)
    return [Problem(f"{step:g} m", _changed(level, {**_grid(step, 5.0), "kappa_max": 1e9})) for step in steps]
