"""Stage one as a whole: moves, bounds, core, program, and the moves of the route followed until all hold."""

from dataclasses import dataclass, replace

import numpy as np

from pipeline.config import Config
from pipeline.errors import NoSolutionError
from pipeline.machine.geometry import FloatArray, IntArray, Machine
from pipeline.progress import Progress, silent
from pipeline.route.follow import Flaw, check_moves
from pipeline.route.highs import solver_name
from pipeline.route.metric import step_sizes
from pipeline.route.moves import Moves, find_moves
from pipeline.route.prove import Optimum, find_optimum
from pipeline.route.regions import RegionTable
from pipeline.route.relaxation import Bounds, fewest_moves, shortest_paths
from pipeline.route.result import Route, Search
from pipeline.route.rules import rule_violations
from pipeline.route.travel import calm_travel
from pipeline.status import Status


def plan_route(
    config: Config, machine: Machine, regions: RegionTable, progress: Progress = silent, verbose: bool = False
) -> Route:
    """Find the route of least sum of kappa (5), proven over the admitted moves, every move followed continuously.

    Raises
    ------
    NoSolutionError
        When no route exists (proven), or the solver's time limit or the rounds run out.
    """
    moves = find_moves(config, machine, regions, progress)
    progress("route: shortest paths")
    bounds = shortest_paths(regions, moves)
    _require_relaxation(config, regions, moves, bounds)
    admitted = moves
    flaws: list[Flaw] = []
    at_least = 0.0
    for round_ in range(1, config.route.max_rounds + 1):
        progress(f"route: round {round_}, {len(moves) - len(admitted)} moves forbidden")
        optimum = find_optimum(config, regions, admitted, bounds, progress, verbose, at_least)
        if optimum is None:
            raise _no_route(regions, moves, flaws)
        placed = _place(config, regions, optimum)
        _require_rules(config, regions, placed)
        bad, found = _flawed_moves(config, machine, placed)
        if not found:
            return _route(placed, optimum, bounds, len(moves), len(moves) - len(admitted), round_)
        flaws += found
        at_least = float(placed.steps.kappa[:-1].sum())
        admitted = _without(admitted, placed.region[bad], placed.region[bad + 1], len(regions))
    raise NoSolutionError(
        "route",
        f"after {config.route.max_rounds} rounds the best route still has moves that fail when followed continuously "
        f"({_count(flaws)})",
        "raise route.max_rounds, or choose a finer grid: moves become shorter and fail less",
    )


def _require_relaxation(config: Config, regions: RegionTable, moves: Moves, bounds: Bounds) -> None:
    """Refuse what the graph alone shows to be impossible: that is a proof."""
    if not np.isfinite(bounds.optimum):
        reached = int(np.isfinite(bounds.forward).sum())
        raise NoSolutionError(
            "route",
            f"no route exists on these {len(regions):,} regions. From the start {reached:,} of them can be reached "
            f"over {len(moves):,} admitted moves, and the goal is not among them (proven by exhausting them)",
            f"allow more tilt (task.tilt_max_deg is {config.task.tilt_max_deg:g}), unlock an axis, allow a larger "
            "route.kappa_max or less clearance, or refine the grid",
            {
                "status": Status.INFEASIBLE.value,
                "regions": len(regions),
                "moves": len(moves),
                "reached": reached,
            },
        )
    hops = fewest_moves(regions, moves)
    if hops is not None and hops + 1 > config.route.step_budget:
        raise NoSolutionError(
            "route",
            f"every route needs at least {hops + 1} positions (proven); "
            f"route.step_budget allows {config.route.step_budget}",
            f"set route.step_budget to {hops + 1} or more, or coarsen the grid",
            {"status": Status.INFEASIBLE.value, "fewest_positions": hops + 1},
        )


def _no_route(regions: RegionTable, moves: Moves, flaws: list[Flaw]) -> NoSolutionError:
    because = f", after {len(flaws)} moves were forbidden that fail when followed ({_count(flaws)})" if flaws else ""
    return NoSolutionError(
        "route",
        f"no route exists on these {len(regions):,} regions within the step budget and the travel along X{because} "
        "(proven)",
        "raise route.step_budget or route.x_step_m, allow more tilt, or refine the grid",
        {"status": Status.INFEASIBLE.value, "regions": len(regions), "moves": len(moves)},
    )


def _count(flaws: list[Flaw]) -> str:
    return "; ".join(f"{flaws.count(flaw)}: {flaw}" for flaw in Flaw if flaw in flaws)


@dataclass(frozen=True, eq=False)
class _Placed:
    """A sequence of regions with its x: rows of the table, columns as in `Route`."""

    region: IntArray
    steps: RegionTable
    pose: FloatArray
    q_m: FloatArray


def _place(config: Config, regions: RegionTable, optimum: Optimum) -> _Placed:
    """Turn a sequence of regions into poses and actuator positions, with the calmest travel along X."""
    sequence, options = optimum.sequence, config.route
    steps = regions.take(sequence.region)
    x = calm_travel(steps.x_window_m, options.x_step_m, options.time_limit_s, sequence.x_m)
    q, pose = steps.q_m.copy(), steps.pose
    q[:, :3] += (x - pose[:, 0])[:, None]
    pose[:, 0] = x
    return _Placed(sequence.region, steps, pose, q)


def _require_rules(config: Config, regions: RegionTable, placed: _Placed) -> None:
    """Hold the solver's result against the rules alone: nothing is taken on trust."""
    options = config.route
    broken = rule_violations(regions, placed.region, placed.pose[:, 0], step_sizes(options), options.step_budget)
    if broken:
        raise NoSolutionError(
            "route",
            f"the solver returned a sequence that breaks the rules: {'; '.join(broken)}",
            "this is a numerical failure: change route.grid or route.x_step_m a little",
            {"status": Status.NOT_CONVERGED.value, "broken": broken},
        )


def _route(placed: _Placed, optimum: Optimum, bounds: Bounds, moves: int, forbidden: int, rounds: int) -> Route:
    """Put the result together: the steps, and how their optimality was proven."""
    kappa, bound = placed.steps.kappa, optimum.sequence.outcome.bound
    objective = float(kappa[:-1].sum())
    search = Search(
        solver=solver_name(),
        bound=bound,
        gap=_gap(objective, bound),
        relaxation=bounds.optimum,
        threshold=optimum.threshold,
        core_regions=optimum.regions,
        core_columns=optimum.sequence.columns,
        moves=moves,
        rounds=rounds,
        forbidden_moves=forbidden,
    )
    return Route(
        region=placed.region,
        modes=placed.steps.mode,
        gates=placed.steps.gate,
        pose=placed.pose,
        q_m=placed.q_m,
        kappa=kappa,
        objective=objective,
        status=Status.OPTIMAL,
        search=search,
    )


def _gap(objective: float, bound: float) -> float:
    """Relative distance of the objective to its bound; rounding in either sum counts as none."""
    gap = (objective - bound) / objective
    return gap if gap > 1e-9 else 0.0


def _flawed_moves(config: Config, machine: Machine, placed: _Placed) -> tuple[IntArray, list[Flaw]]:
    """Follow every move of a route; give the first steps of the bad ones and what is wrong with them."""
    first = np.arange(len(placed.region) - 1)
    ends = np.stack([first, first + 1], axis=1)
    checks = check_moves(config, machine, placed.pose[ends], placed.q_m[ends])
    return first[~checks.good], [flaw for flaw in checks.flaw if flaw is not None]


def _without(moves: Moves, source: IntArray, target: IntArray, regions: int) -> Moves:
    """The moves less those between the given regions, in either direction: both follow the same line."""
    bad = np.concatenate([source * regions + target, target * regions + source])
    keep = ~np.isin(moves.source.astype(np.int64) * regions + moves.target, bad)
    return replace(moves, source=moves.source[keep], target=moves.target[keep])
