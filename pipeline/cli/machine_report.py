"""A machine and its task as tables: geometry, reach, grid, start and goal."""

import math
from collections.abc import Iterator

import numpy as np
from rich.console import RenderableType
from rich.table import Table

from pipeline.cli.machine_notes import machine_notes
from pipeline.cli.output import text_table
from pipeline.config import Config
from pipeline.config.machine.links import RailConfig
from pipeline.limits import KINDS, ShownLimit, read_measures, unlimited_measures
from pipeline.limits.actuator_margins import planned_range_m
from pipeline.limits.bodies.pairs import kept_apart, pair_distances, pair_names
from pipeline.limits.holding_force import holding_limit
from pipeline.machine.actuator_space import actuator_rates, amplification, drive_figures, mode_words
from pipeline.machine.geometry import ACTUATORS, ARM_OF_LINK, LINKS, MODES, TELESCOPES, TRIANGLE, Machine
from pipeline.route.regions.endpoints import Endpoint
from pipeline.route.regions.grid import grid_axes
from pipeline.route.regions.size import expected_size
from pipeline.workspace.reach import reach_step, usable_reach

_NEAREST = 20
"""Pairs of bodies that are listed."""


def machine_report(config: Config, machine: Machine, ends: tuple[Endpoint, Endpoint]) -> list[RenderableType]:
    """Describe a machine and its task."""
    return [
        *refused_report(config, machine, {"start": ends[0], "goal": ends[1]}),
        *machine_notes(config, machine, ends[0]),
    ]


def refused_report(config: Config, machine: Machine, ends: dict[str, Endpoint]) -> list[RenderableType]:
    """Describe a machine and as much of its task as there is: `ends` are those of start and goal within reach."""
    found: list[RenderableType] = [
        _degrees_of_freedom(config),
        _actuators(config, machine),
        _limits(machine),
        _links(machine),
        _reach(config, machine),
        _grid(config, machine),
    ]
    if len(ends) == 2:
        both = (ends["start"], ends["goal"])
        found += [_ends(config, machine, both), _drives(machine, both)]
    return [*found, *_bodies(config, machine, ends)]


def _degrees_of_freedom(config: Config) -> str:
    locked = config.task.locked_axes
    axes = [axis for axis in ("x", "y", "z", "rx", "rz") if axis not in locked]
    held = f" {' and '.join(locked)} held at zero;" if locked else ""
    return (
        f"{config.name}: {len(ACTUATORS)} actuators, {len(axes)} degrees of freedom in this task "
        f"({', '.join(axes)});{held} ry follows from the triangle of links 3a and 3c"
    )


def _table(title: str, *columns: str, text: int = 1) -> Table:
    """Make a table whose first `text` columns are words, the others numbers."""
    return text_table(title, columns, (), range(text))


def _actuators(config: Config, machine: Machine) -> Table:
    table = _table("Actuators", "actuator", "what", "least m", "largest m", "path least m", "largest m", text=2)
    carts = [
        f"cart of arm {k + 1}, rail at y {rail.y_m:g} m, z {rail.z_m:g} m{_slopes(rail)}"
        for k, rail in enumerate(config.machine.rails)
    ]
    telescopes = [f"telescopic link {LINKS[link]}" for link in TELESCOPES]
    ranges = np.hstack([machine.actuator_limits_m, planned_range_m(config, machine)])
    for name, what, row in zip(ACTUATORS, carts + telescopes, ranges, strict=True):
        table.add_row(name, what, *(f"{value:g}" for value in row))
    return table


def _slopes(rail: RailConfig) -> str:
    """Say how far a rail is off X, if it is."""
    return f", {1e3 * rail.slopes[0]:g} and {1e3 * rail.slopes[1]:g} mm/m off X" if any(rail.slopes) else ""


def _limits(machine: Machine) -> Table:
    masses = "" if machine.masses is not None else "; no masses are given, so forces are not checked"
    units = ("velocity m/s", "acceleration m/s^2", "jerk m/s^3", "force N")
    table = _table(f"Limits of motion{masses}", "of", *units)
    rows = np.column_stack([machine.velocity_mps, machine.acceleration_mps2, machine.jerk_mps3])
    push_and_pull, count = machine.force_limits_n, len(ACTUATORS)
    tcp = (machine.tcp_speed_mps, machine.tcp_acceleration_mps2, np.inf)
    of = (*ACTUATORS, "TCP", "links")
    forces = [*push_and_pull[:, :count].T, np.full(2, np.inf), push_and_pull[:, count]]
    for name, row, force in zip(of, (*rows.tolist(), tcp, np.full(3, np.inf)), forces, strict=True):
        table.add_row(name, *(f"{value:g}" if np.isfinite(value) else "-" for value in row), _force_words(*force))
    return table


def _force_words(push: float, pull: float) -> str:
    if push == pull:
        return f"{push:g}" if np.isfinite(push) else "-"
    return f"push {push:g}, pull {pull:g}"


def _links(machine: Machine) -> Table:
    table = _table("Links", "link", "arm", "kind", "length m", text=3)
    for link, name in enumerate(LINKS):
        length = machine.lengths_m[link]
        kind = "telescope" if link in TELESCOPES else "triangle" if link == TRIANGLE else "fixed"
        stroke = dict(zip(TELESCOPES.tolist(), machine.strokes_m, strict=True)).get(link)
        text = f"{length:.6g}" if stroke is None else f"{stroke[0]:g} to {stroke[1]:g}"
        table.add_row(name, str(ARM_OF_LINK[link] + 1), kind, text)
    return table


def _reach(config: Config, machine: Machine) -> Table:
    cap, step = config.route.kappa_max, reach_step(machine)
    table = _table(
        f"Reach without tilt (kappa up to {cap:g}, strokes, carts and clearance kept; to {step:.2g} m)",
        "working mode",
        "x m",
        "y m",
        "z m",
        "area m^2",
    )
    for mode in dict.fromkeys((config.task.start.mode, config.task.goal.mode)):
        reach = usable_reach(machine, MODES.index(mode), cap, step)
        spans = [
            "none" if span is None else f"{span[0]:.2f} to {span[1]:.2f}" for span in (reach.x_m, reach.y_m, reach.z_m)
        ]
        table.add_row(mode, *spans, f"{reach.area_m2:.2f}")
    return table


def _grid(config: Config, machine: Machine) -> Table:
    axes = grid_axes(config)
    count = len(MODES) * math.prod(len(axis) for axis in axes)
    size = expected_size(config, machine)
    table = _table(
        f"Grid: {count:,} candidates in {len(MODES)} working modes, plus gates; about {_rounded(size.regions)} regions "
        f"and {_rounded(size.moves)} moves in {_rounded(size.memory_gb)} GB of memory, "
        f"allowed {config.route.memory_gb:g}",
        "axis",
        "least",
        "largest",
        "step",
        "points",
    )
    grid = config.route.grid
    steps = (grid.y_m.step, grid.z_m.step, grid.rx_step_deg, grid.rz_step_deg)
    for name, axis, step in zip(("y m", "z m", "rx deg", "rz deg"), axes, steps, strict=True):
        values = np.rad2deg(axis) if name.endswith("deg") else axis
        table.add_row(name, f"{values[0]:.4g}", f"{values[-1]:.4g}", f"{step:g}", str(len(axis)))
    return table


def _rounded(value: float) -> str:
    """Give two digits: an estimate has no more."""
    return f"{float(f'{value:.2g}'):,g}" if value < 1e6 else f"{float(f'{value:.2g}') / 1e6:,g} million"


def _ends(config: Config, machine: Machine, ends: tuple[Endpoint, Endpoint]) -> Table:
    table = _table("Task", "quantity", "unit", "start", "goal", "limit", text=2)
    table.add_row("working mode", "", *(MODES[end.mode] for end in ends), "")
    tilt = f"+/- {config.task.tilt_max_deg:g}"
    for index, (name, limit) in enumerate((("x", ""), ("y", ""), ("z", ""), ("rx", tilt), ("ry", ""), ("rz", tilt))):
        values = [end.pose[index] for end in ends]
        unit = "m" if index < 3 else "deg"
        shown = values if index < 3 else [np.rad2deg(value) for value in values]
        table.add_row(name, unit, *(f"{value:.4f}" for value in shown), limit)
    machine_limits = [*(rail.travel_m for rail in config.machine.rails)]
    machine_limits += [config.machine.links.l2b.stroke_m, config.machine.links.l3b.stroke_m]
    for index, (name, (least, largest)) in enumerate(zip(ACTUATORS, machine_limits, strict=True)):
        table.add_row(name, "m", *(f"{end.q_m[index]:.4f}" for end in ends), f"{least:g} to {largest:g}")
    for name, forces, limit in _resting(machine, ends):
        table.add_row(f"{name} holds", "N", *(f"{force:.1f}" for force in forces), limit)
    table.add_row("kappa", "", *(f"{end.kappa:.3f}" for end in ends), f"<= {config.route.kappa_max:g}")
    table.add_row("sign of det H", "", *(f"{end.det_sign:+.0f}" for end in ends), "equal")
    for name, unit, values, limit in _limited(config, machine, ends):
        table.add_row(name, unit, *(f"{value:.4f}" for value in values), limit)
    return table


def _limited(
    config: Config, machine: Machine, ends: tuple[Endpoint, Endpoint]
) -> Iterator[tuple[str, str, list[float], str]]:
    """Give the limited quantities at start and goal; of kinds without a limit, what is measured all the same."""
    for kind in KINDS:
        for limit in kind.for_poses(machine, config.route.kappa_max):
            if isinstance(limit, ShownLimit):
                for start, goal in zip(*(limit.curves(end.samples) for end in ends), strict=True):
                    yield start.name, start.unit, [float(start.values[0]), float(goal.values[0])], start.allowed
    measures = unlimited_measures(config, machine)
    at_start, at_goal = (read_measures(measures, end.samples) for end in ends)
    others = {other.name: other.value for other in at_goal}
    for one in at_start:
        if one.name in others:
            yield one.name, one.unit, [one.value, others[one.name]], one.allowed


def _drives(machine: Machine, ends: tuple[Endpoint, Endpoint]) -> RenderableType:
    """Say what the drives feel at start and goal, at rest; without masses, how far the TCP moves with them."""
    rates = [actuator_rates(machine, end.pose[None], end.q_m[None, :3]) for end in ends]
    known = machine.masses is not None
    table = _table(f"Drives{'' if known else '; no masses are given'}", "quantity", "unit", "start", "goal", text=2)
    if known:
        felt = [drive_figures(machine, rate, np.zeros((1, len(ACTUATORS)))) for rate in rates]
        for k, name in enumerate(ACTUATORS):
            table.add_row(f"reflected mass of {name}", "kg", *(f"{one.reflected_mass_kg[0, k]:.1f}" for one in felt))
        table.add_row("in the worst direction", "kg", *(f"{one.worst_mass_kg.value[0]:.1f}" for one in felt))
        table.add_row("gravity stiffness", "N/m", *(f"{one.stiffness_npm.value[0]:.0f}" for one in felt))
        table.add_row("", "along", *(mode_words(one.stiffness_npm.along[0]) for one in felt))
    gains = [amplification(rate) for rate in rates]
    table.add_row("TCP per actuators", "mm/mm", *(f"{one.position.value[0]:.2f}" for one in gains))
    table.add_row("", "mrad/mm", *(f"{one.angle.value[0]:.2f}" for one in gains))
    return table


def _bodies(config: Config, machine: Machine, ends: dict[str, Endpoint]) -> Iterator[RenderableType]:
    """List bodies and obstacles, what touches by construction, and the nearest pairs at start and goal."""
    groups = kept_apart(config, machine)
    if not groups:
        return
    count, least = sum(len(pairs.names) for pairs in groups), config.machine.clearance.bodies_m
    obstacles = [obstacle.name for obstacle in config.task.obstacles]
    title = f"Bodies: {count} pairs are kept {least:g} m apart"
    table = _table(title, "body", "moves with", "points", "radius m", text=2)
    for hull in {hull.name: hull for pairs in groups for hull in pairs.hulls}.values():
        moves_with = "nothing, an obstacle" if hull.name in obstacles else hull.moves_with
        table.add_row(hull.name, moves_with, str(len(hull.points_m)), f"{hull.radius_m:g}")
    yield table
    neighbours = [(one.name, one.why, one.treatment) for pairs in groups for one in pairs.neighbours]
    if neighbours:
        yield text_table("Bodies that touch by construction", ("pair", "why", "treatment"), neighbours, range(3))
    if not ends:
        return
    names = pair_names(groups)
    distances = np.array([pair_distances(groups, end.samples)[0] for end in ends.values()])
    order = np.argsort(distances.min(axis=0), kind="stable").tolist()
    # Of every obstacle, the pair nearest to it is shown, too, however far away it is.
    of_obstacles = [next((k for k in order if names[k].endswith(f" and {name}")), order[0]) for name in obstacles]
    shown = list(dict.fromkeys([*order[:_NEAREST], *sorted(of_obstacles, key=order.index)]))
    more = count - len(shown)
    rest = f"; {more} more pairs are farther apart than the first {_NEAREST}" if more > 0 else ""
    columns = (f"{name} m" for name in ends)
    table = _table(f"Distances of bodies, the nearest first{rest}", "pair", *columns)
    for k in shown:
        table.add_row(names[k], *(f"{value:.4f}" for value in distances[:, k]))
    yield table


def _resting(machine: Machine, ends: tuple[Endpoint, Endpoint]) -> Iterator[tuple[str, list[float], str]]:
    """Give the forces that each drive, and the links, hold at start and goal; nothing without masses."""
    if machine.masses is None:
        return
    forces = np.concatenate([end.samples.holding_forces_n for end in ends])
    limit = holding_limit(machine)
    count = len(ACTUATORS)
    allowed = np.full((2, forces.shape[1]), np.inf) if limit is None else limit.allowed_at_rest_n
    drives, links = forces[:, :count], forces[:, count:]
    push, pull = allowed[:, count]
    if push == pull:
        groups = [("any link", np.abs(links).max(axis=1), push, pull)]
    else:
        groups = [
            ("any link, pushed", links.max(axis=1), push, np.inf),
            ("any link, pulled", links.min(axis=1), np.inf, pull),
        ]
    drive_rows = zip(ACTUATORS, drives.T, *allowed[:, :count], strict=True)
    for name, column, push, pull in (*drive_rows, *groups):
        yield name, column.tolist(), _range_words(-pull, push)


def _range_words(least: float, largest: float) -> str:
    if np.isinf([least, largest]).any():
        return "" if np.isinf([least, largest]).all() else f">= {least:g}" if np.isinf(largest) else f"<= {largest:g}"
    return f"+/- {largest:g}" if least == -largest else f"{least:g} to {largest:g}"
