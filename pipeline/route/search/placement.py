"""From a sequence of regions to a route: x for every step, poses, actuator positions, and a look at all rules."""

from dataclasses import dataclass

import numpy as np

from pipeline.arrays import FloatArray, IntArray
from pipeline.config import Config
from pipeline.errors import NoSolutionError
from pipeline.machine.geometry import Machine
from pipeline.route.metric import step_sizes
from pipeline.route.moves.check import check_moves
from pipeline.route.moves.rejections import Rejection
from pipeline.route.programs.core_program import StepSequence
from pipeline.route.regions.table import RegionTable
from pipeline.route.search.gate_modes import fewest_mode_changes
from pipeline.route.search.rule_check import rule_violations, task_violations
from pipeline.route.search.x_positions import smoothest_x
from pipeline.status import Status


@dataclass(frozen=True, eq=False)
class PlacedRoute:
    """A sequence of regions with its x: rows of the table, columns as in `Route`."""

    region: IntArray
    steps: RegionTable
    pose: FloatArray
    q_m: FloatArray

    @property
    def visits(self) -> IntArray:
        """The visit made at each step, in their turn; passing by what was visited before is none."""
        visits = np.zeros(len(self.region), dtype=np.int64)
        for step, stop in enumerate(self.steps.visits.tolist()):
            if stop == visits.max() + 1:
                visits[step] = stop
        return visits

    @property
    def objective(self) -> float:
        """The sum of kappa (5)."""
        return float(self.steps.kappa[:-1].sum())


def place_route(config: Config, regions: RegionTable, sequence: StepSequence) -> PlacedRoute:
    """Turn a sequence of regions into poses and actuator positions, with the fewest changes and the calmest travel.

    Raises
    ------
    NoSolutionError
        When the sequence breaks a rule of the paper or a budget: nothing a solver returns is taken on trust.
    """
    rows = fewest_mode_changes(regions, sequence.region)
    steps = regions.take(rows)
    options = config.route
    x = smoothest_x(steps.x_window_m, options.x_step_m, options.time_limit_s, sequence.x_m)
    if _broken(config, regions, rows, x):
        # The calmest travel is known to the tolerance of its program only, which a tight budget may not forgive.
        x = sequence.x_m
    if broken := _broken(config, regions, rows, x):
        raise NoSolutionError(
            "route",
            f"the solver returned a sequence that breaks the rules: {'; '.join(broken)}",
            "this is a numerical failure: change route.grid or route.x_step_m a little",
            {"status": Status.NOT_CONVERGED.value, "broken": broken},
        )
    q, pose = steps.q_m.copy(), steps.pose
    q[:, :3] += (x - pose[:, 0])[:, None]
    pose[:, 0] = x
    return PlacedRoute(rows, steps, pose, q)


def _broken(config: Config, regions: RegionTable, rows: IntArray, x_m: FloatArray) -> list[str]:
    of_the_paper = rule_violations(regions, rows, x_m, step_sizes(config.route), config.route.step_budget)
    return of_the_paper + task_violations(config, regions, rows, x_m)


def flawed_moves(config: Config, machine: Machine, placed: PlacedRoute) -> list[tuple[int, Rejection]]:
    """Follow every move of a sequence; give the first step of each bad one and what is wrong with it."""
    first = np.arange(len(placed.region) - 1)
    ends = np.stack([first, first + 1], axis=1)
    checks = check_moves(config, machine, placed.pose[ends], placed.q_m[ends])
    return [(step, flaw) for step, flaw in enumerate(checks.rejections) if flaw is not None]
