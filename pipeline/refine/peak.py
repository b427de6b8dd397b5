"""Lowering the largest kappa of a path: step by step, each step a solve that starts from the one before."""

import numpy as np

from pipeline.config import Config
from pipeline.errors import NoSolutionError
from pipeline.refine.between import breaches
from pipeline.refine.measure import PathFigures, sample_path
from pipeline.refine.motion import kappa_along
from pipeline.refine.result import Path
from pipeline.refine.solve import Aim, Problem, Solve, figures_of, solve_on
from pipeline.route.metric import arc_length

_AIM = 0.97
"""Share of the coarse path's largest kappa that the integral's objective aims at, too: peaks are to come down."""
_BELOW_CAP = 0.995
"""Share of the cap aimed at: between two nodes kappa may be a little higher than at them."""
_GAIN = 0.001
"""Relative gain below which lowering the largest kappa further is not worth a solve."""
_FIRST_STEP = {"integral": 0.05, "mixed": 0.01, "maximum": 0.01}
"""The largest kappa is lowered in steps of this share, small ones where it is to go as low as it gets."""
_SHORTER, _LAST_STEP = 3.0, 0.003
"""Steps get shorter by this factor when one fails, down to a last one."""
_ITERATIONS = 60
"""A step that takes more is none."""
_ENDS = np.array([0.0, 1.0])


def lowered(problem: Problem, solve: Solve, exponent: float, evenness: float) -> tuple[Solve, int]:
    """Lower the largest kappa as far as the objective asks for; also the iterations it took.

    A step that is no gain, does not converge or breaks a promise is taken back and a shorter one tried. Start and goal
    are given, and so is their kappa.
    """
    iterations, figures, objective = 0, figures_of(problem, solve), problem.config.refine.objective
    aimed, cap = _aim_and_cap(problem.config, problem.coarse)
    target = max(float(kappa_along(solve.path, _ENDS).max()), aimed if objective == "integral" else 0.0)
    step = _FIRST_STEP[objective]
    while step > _LAST_STEP and figures.kappa_max > target * (1.0 + _GAIN):
        problem.progress(f"refine: largest kappa {figures.kappa_max:.3f}, lowering it")
        next_ = min(max(target, (1.0 - step) * figures.kappa_max), cap)
        aim = Aim(exponent, (1.0, 1.0), (next_, cap), evenness, _ITERATIONS, "near")
        try:
            tried = solve_on(problem, solve.mesh, solve.start, aim)
        except NoSolutionError:
            step /= _SHORTER
            continue
        iterations += tried.solution.iterations
        there = figures_of(problem, tried)
        worse = _worth(problem, there) >= _worth(problem, figures) * (1.0 - _GAIN)
        if worse or breaches(problem.config, problem.route, tried.path, problem.coarse):
            step /= _SHORTER
            continue
        solve, figures = tried, there
    return solve, iterations


def _worth(problem: Problem, figures: PathFigures) -> float:
    """What is to be small: the largest kappa, or its mean with the average of kappa along the path."""
    if problem.config.refine.objective == "mixed":
        length = float(arc_length(problem.coarse.node_pose, problem.steps)[-1])
        return (figures.kappa_max + figures.kappa_integral / length) / 2.0
    return figures.kappa_max


def _aim_and_cap(config: Config, coarse: Path) -> tuple[float, float]:
    """What is aimed at for the largest kappa, a little less than on the coarse path, and its cap."""
    largest = float(sample_path(coarse, np.linspace(0.0, 1.0, config.refine.check_points)).kappa.max())
    cap = min(config.refine.kappa_max or np.inf, config.route.kappa_max)
    return min(_AIM * largest, _BELOW_CAP * cap), cap
