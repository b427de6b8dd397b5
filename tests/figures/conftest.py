"""A plausible route and two paths in one working mode, without the stages that make real ones."""

from collections.abc import Callable
from itertools import combinations

import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.transforms import Bbox

from pipeline.arrays import FloatArray
from pipeline.machine import MODES, Machine, condition_number, inverse_kinematics, statics_matrix
from pipeline.refine.measure import PathSamples
from pipeline.retime.result import TrajectorySamples
from pipeline.route.result import Route, Search
from pipeline.status import Status

SEARCH = Search(
    solver="none",
    bound=0.0,
    gap=0.0,
    relaxation=0.0,
    threshold=0.0,
    core_regions=0,
    core_columns=0,
    moves=0,
    rounds=1,
    followed_moves=0,
    forbidden_moves=0,
    least_kappa_max=0.0,
)


def controlled_curve(s: FloatArray, sway_m: float = 0.0) -> FloatArray:
    """Evaluate a gentle curve of controlled poses within the reach of mode LLL, shape (n, 5)."""
    y = 0.3 + 0.2 * s + sway_m * np.sin(6.0 * np.pi * s)
    z = 0.9 - 0.2 * np.sin(np.pi * s)
    tilt = np.deg2rad(15.0) * np.sin(np.pi * s)
    return np.column_stack([np.full_like(s, 1.02), y, z, -tilt, -0.5 * tilt])


def make_route(machine: Machine, controlled: FloatArray, mode: str = "LLL") -> Route:
    """Make a route through controlled poses (n, 5), all in one working mode."""
    n = len(controlled)
    solution = inverse_kinematics(machine, controlled, np.full(n, MODES.index(mode)))
    assert solution.reachable.all()
    kappa = condition_number(statics_matrix(machine, solution.pose, solution.q_m[:, :3]))
    return Route(
        region=np.arange(n),
        modes=np.full(n, MODES.index(mode)),
        gates=np.zeros(n, dtype=np.int64),
        visits=np.zeros(n, dtype=np.int64),
        pose=solution.pose,
        q_m=solution.q_m,
        kappa=kappa,
        objective=float(kappa[:-1].sum()),
        status=Status.OPTIMAL,
        search=SEARCH,
    )


def make_samples(machine: Machine, controlled: FloatArray, mode: str = "LLL") -> PathSamples:
    """Sample a path through controlled poses (n, 5), all in one working mode."""
    solution = inverse_kinematics(machine, controlled, np.full(len(controlled), MODES.index(mode)))
    return samples_at(machine, solution.pose, solution.q_m)


def samples_at(machine: Machine, pose: FloatArray, q_m: FloatArray) -> PathSamples:
    """Sample a path through poses (n, 6) with actuator positions (n, 5)."""
    return PathSamples(machine, pose, q_m, np.linspace(0.0, 1.0, len(pose)))


@pytest.fixture(scope="session")
def route(machine: Machine) -> Route:
    """Give a route of 15 steps."""
    return make_route(machine, controlled_curve(np.linspace(0.0, 1.0, 15), sway_m=0.02))


@pytest.fixture(scope="session")
def coarse(machine: Machine) -> PathSamples:
    """Give a swaying path through all steps of the route."""
    return make_samples(machine, controlled_curve(np.linspace(0.0, 1.0, 141), sway_m=0.02))


@pytest.fixture(scope="session")
def refined(machine: Machine) -> PathSamples:
    """Give a shorter path between the same ends."""
    return make_samples(machine, controlled_curve(np.linspace(0.0, 1.0, 101)))


@pytest.fixture(scope="session")
def trajectory(refined: PathSamples) -> TrajectorySamples:
    """Drive the refined path within a second."""
    t = np.linspace(0.0, 1.0, len(refined.s))
    qd = np.gradient(refined.q_m, t, axis=0)
    return TrajectorySamples(
        period_s=0.01,
        t_s=t,
        q_m=refined.q_m,
        qd_mps=qd,
        qdd_mps2=np.gradient(qd, t, axis=0),
        pose=refined.pose,
        kappa=refined.kappa,
    )


def _legends_and_axes(figure: Figure) -> list[Bbox]:
    renderer = FigureCanvasAgg(figure).get_renderer()
    figure.draw_without_rendering()
    boxes = [axes.get_tightbbox(renderer) for axes in figure.axes]
    return [*boxes, *(legend.get_window_extent(renderer) for legend in figure.legends)]


@pytest.fixture(scope="session")
def assert_laid_out() -> Callable[[Figure], None]:
    """Check a figure's layout: nothing sticks out of the page and no panel, label or legend covers another."""

    def check(figure: Figure) -> None:
        boxes = _legends_and_axes(figure)
        width, height = figure.get_size_inches() * figure.dpi
        tolerance = 0.01 * figure.dpi
        for box in boxes:
            assert box.x0 > -tolerance
            assert box.y0 > -tolerance
            assert box.x1 < width + tolerance
            assert box.y1 < height + tolerance
        for a, b in combinations(boxes, 2):
            common = Bbox.intersection(a, b)
            assert common is None or min(common.width, common.height) < 3.0 * tolerance, (a, b)

    return check
