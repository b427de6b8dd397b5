"""The problem of stage one: a route through given regions, over given moves."""

from dataclasses import dataclass

from pipeline.arrays import FloatArray
from pipeline.config import Config, RouteConfig
from pipeline.machine.geometry import Machine
from pipeline.progress import QUIET, Monitor
from pipeline.route.bounds.budgets import Budget, task_budgets
from pipeline.route.bounds.shortest_paths import Bounds
from pipeline.route.cost.interface import MoveCost
from pipeline.route.cost.objectives import COSTS
from pipeline.route.deadline import Deadline
from pipeline.route.metric import step_sizes
from pipeline.route.moves.candidates import Moves
from pipeline.route.regions.table import RegionTable


@dataclass(frozen=True, eq=False)
class RouteProblem:
    """What a route is asked for, and the regions and moves it is sought among.

    Attributes
    ----------
    config, machine : Config, Machine
    regions, moves : RegionTable, Moves
        All of the configuration, with the moves that the grid admits between them.
    steps : (5,)
        Largest moves per step of x, y, z (metres), rx, rz (radians), (13)-(17).
    budgets : tuple of Budget
        Those of `task.budget`.
    cost : MoveCost
        What the objective adds up.
    monitor : Monitor
        Receives progress and decides whether solvers write their logs.
    deadline : Deadline
        When the search ends.
    shortest : Bounds, optional
        The shortest paths over regions and moves, budgets and travel left out, where they are known.
    guided : bool
        Whether `Search.least_kappa_max` is computed, which guides stage two; it is infinite otherwise.
    """

    config: Config
    machine: Machine
    regions: RegionTable
    moves: Moves
    steps: FloatArray
    budgets: tuple[Budget, ...]
    cost: MoveCost
    monitor: Monitor
    deadline: Deadline
    shortest: Bounds | None = None
    guided: bool = True

    @classmethod
    def of(
        cls, config: Config, machine: Machine, regions: RegionTable, moves: Moves, monitor: Monitor = QUIET
    ) -> "RouteProblem":
        """Derive steps, budgets and costs from the configuration, and start the clock of `route.time_limit_s`."""
        steps, cost = step_sizes(config.route), COSTS[config.route.objective](config.route, machine)
        deadline = Deadline.after(config.route.time_limit_s, config.route.objective)
        return cls(config, machine, regions, moves, steps, task_budgets(config), cost, monitor, deadline)

    def ceiling(self, regions: RegionTable) -> float:
        """Bound the cost of every route through regions within the step budget from above."""
        return self.options.step_budget * self.cost.most(regions)

    @property
    def options(self) -> RouteConfig:
        """The options of stage one."""
        return self.config.route
