"""Problems for stage one, and independent ways to solve and to judge them."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from pipeline.config import Config
from pipeline.machine import Machine, build_machine
from pipeline.route import RegionTable, Route, build_regions
from pipeline.route.bounds.shortest_paths import Bounds
from pipeline.route.core.build import Core, build_core
from pipeline.route.moves.candidates import Moves, find_moves
from pipeline.route.problem import RouteProblem
from tests.conftest import WITHOUT_FORCE_LIMITS

RAIL_OF_LINK = [0, 1, 1, 2, 2, 2]


@dataclass(frozen=True, eq=False)
class Problem:
    """A configuration with its machine, its regions and the moves between them."""

    config: Config
    machine: Machine
    regions: RegionTable
    moves: Moves


@pytest.fixture(scope="session")
def quick_config(quick_config: Config, vary) -> Config:
    """Minimise the sum (5) unless a test says otherwise: its optima are known from others, and x is free."""
    return vary(quick_config, {"route.objective": "sum"})


@pytest.fixture(scope="session")
def pose_problem() -> Callable[[Config], Problem]:
    """Give a function that computes the regions and moves of a configuration."""

    def pose(config: Config) -> Problem:
        machine = build_machine(config.machine)
        regions = build_regions(config, machine)
        return Problem(config, machine, regions, find_moves(config, machine, regions))

    return pose


@pytest.fixture(scope="session")
def cross_config(quick_config: Config, vary) -> Config:
    """Make the discretisation that others computed, too: no limits on the telescopes, endless rails."""
    strokes = {f"machine.links.{link}.stroke_m": [0.01, 9.0] for link in ("l2b", "l3b")}
    return vary(
        quick_config, WITHOUT_FORCE_LIMITS | strokes | {f"machine.rails.{k}.travel_m": [-10.0, 10.0] for k in range(3)}
    )


@pytest.fixture(scope="session")
def cross(cross_config: Config, pose_problem) -> Problem:
    """Compute the regions and moves of `cross_config`."""
    return pose_problem(cross_config)


@pytest.fixture(scope="session")
def quick(quick_config: Config, pose_problem) -> Problem:
    """Compute the regions and moves of quick.yaml."""
    return pose_problem(quick_config)


@pytest.fixture(scope="session")
def small_config(cross_config: Config, vary) -> Config:
    """Cut a piece around the start and the goal out of `cross_config`: gates of all arms, a thousand regions."""
    return vary(
        cross_config,
        {
            "route.grid.y_m": {"min": 0.5, "max": 0.8, "step": 0.1},
            "route.grid.z_m": {"min": 0.4, "max": 0.9, "step": 0.1},
            "task.tilt_max_deg": 10,
            "task.start.y_m": 0.55,
            "task.goal.y_m": 0.55,
        },
    )


@pytest.fixture(scope="session")
def small(small_config: Config, pose_problem) -> Problem:
    """Compute the regions and moves of `small_config`."""
    return pose_problem(small_config)


@pytest.fixture(scope="session")
def hand_table() -> Callable[..., RegionTable]:
    """Give a function that makes a region table of windows of x and kappa alone; y is the row's number."""

    def table(windows_m: Iterable[tuple[float, float]], kappa: Iterable[float]) -> RegionTable:
        windows, costs = np.array(windows_m, dtype=float), np.array(kappa, dtype=float)
        n = len(costs)
        controlled = np.zeros((n, 5))
        controlled[:, 1] = np.arange(n)
        controlled[-2:, 0] = windows[-2:, 0]
        return RegionTable(
            controlled=controlled,
            ry_rad=np.zeros(n),
            modes=np.zeros(n, dtype=np.int64),
            gates=np.zeros(n, dtype=np.int64),
            q_m=np.ones((n, 5)),
            kappa=costs,
            det_sign=np.ones(n),
            link_distance_m=np.ones(n),
            x_window_m=windows,
            visits=np.zeros(n, dtype=np.int64),
        )

    return table


@pytest.fixture(scope="session")
def hand_moves() -> Callable[[Iterable[tuple[int, int]]], Moves]:
    """Give a function that makes moves of pairs (source, target)."""

    def moves(pairs: Iterable[tuple[int, int]]) -> Moves:
        columns = np.array(sorted(pairs), dtype=np.int64).reshape(-1, 2)
        return Moves(columns[:, 0], columns[:, 1])

    return moves


@pytest.fixture(scope="session")
def core_of(quick_config: Config, machine: Machine) -> Callable[..., Core]:
    """Give a function that builds the core of regions and moves with bounds, a threshold, N and Delta X, for (5)."""

    def build(
        regions: RegionTable, moves: Moves, bounds: Bounds, threshold: float, positions: int, x_step_m: float
    ) -> Core:
        route = quick_config.route.model_copy(update={"step_budget": positions, "x_step_m": x_step_m})
        problem = RouteProblem.of(quick_config.model_copy(update={"route": route}), machine, regions, moves)
        return build_core(problem, regions, moves, bounds, threshold)

    return build


@pytest.fixture(scope="session")
def random_problem(hand_table, hand_moves) -> Callable[..., tuple[RegionTable, Moves, int]]:
    """Give a function that draws a table of few regions, moves between them and a step budget from a seed."""

    def draw(seed: int, x_free: bool = False) -> tuple[RegionTable, Moves, int]:
        random = np.random.default_rng(seed)
        n = int(random.integers(4, 9))
        low = random.integers(-4, 4, n)
        windows = np.column_stack([low, low + random.integers(0, 3, n)]).astype(float)
        if x_free:
            windows[:] = [-50.0, 50.0]
        windows[-2:, 1] = windows[-2:, 0]
        pairs = [
            (i, j) for i in range(n) for j in range(n) if i not in (j, n - 1) and j != n - 2 and random.random() < 0.5
        ]
        return hand_table(windows, random.integers(2, 20, n)), hand_moves(pairs), int(random.integers(3, 7))

    return draw


@pytest.fixture(scope="session")
def cheapest() -> Callable[..., float]:
    """Give a dynamic program over step, region and reachable x: the least sum (5), infinite without a route.

    Along one sequence of regions the reachable x form an interval, so that labels (cost, least x, largest x) are
    exact; one that costs more and reaches less than another is dropped, and so is one that costs more than `cap`.
    """

    def solve(regions: RegionTable, moves: Moves, positions: int, x_step_m: float, cap: float = np.inf) -> float:
        onwards: dict[int, list[int]] = {}
        for i, j in zip(moves.source.tolist(), moves.target.tolist(), strict=True):
            onwards.setdefault(i, [i]).append(j)
        windows, kappa = regions.x_window_m.tolist(), regions.kappa.tolist()
        to_go = _costs_to_go(regions, moves, positions)
        labels = {regions.start: [(0.0, *windows[regions.start])]}
        best = np.inf
        for _ in range(positions - 1):
            reached: dict[int, list[tuple[float, float, float]]] = {}
            for i, here in labels.items():
                for cost, low, high in here if i != regions.goal else []:
                    for j in onwards.get(i, [i]):
                        least, largest = max(low - x_step_m, windows[j][0]), min(high + x_step_m, windows[j][1])
                        if least <= largest + 1e-9 and cost + kappa[i] + to_go[j] <= cap:
                            reached.setdefault(j, []).append((cost + kappa[i], least, largest))
            best = min([best, *(cost for cost, _, _ in reached.get(regions.goal, []))])
            labels = {j: _undominated(there) for j, there in reached.items()}
        return best

    return solve


def _costs_to_go(regions: RegionTable, moves: Moves, positions: int) -> np.ndarray:
    """Bellman's recursion without x: at least this much is still to be paid from a region on."""
    cost = np.full(len(regions), np.inf)
    cost[regions.goal] = 0.0
    for _ in range(positions):
        onwards = regions.kappa[moves.source] + cost[moves.target]
        np.minimum.at(cost, moves.source, onwards)
    return cost


def _undominated(labels: list[tuple[float, float, float]]) -> list[tuple[float, float, float]]:
    kept: list[tuple[float, float, float]] = []
    for cost, low, high in sorted(labels):
        if not any(c <= cost and least <= low and high <= largest for c, least, largest in kept):
            kept.append((cost, low, high))
    return kept


@pytest.fixture(scope="session")
def joints() -> Callable[..., tuple[np.ndarray, np.ndarray, np.ndarray]]:
    """Give a function that places C_l, A_l and A'_l of all links, (n, 6, 3) each, by another way of rotating."""

    def place(machine: Machine, pose: np.ndarray, q_m: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        turn = Rotation.from_euler("XZY", pose[:, [3, 5, 4]])
        arms = np.stack([turn.apply(point) for point in machine.platform_points_m], axis=1)
        carts = np.zeros_like(arms)
        for link, rail in enumerate(RAIL_OF_LINK):
            carts[:, link, 0] = q_m[:, rail]
            carts[:, link, 1:] = machine.rails_m[rail]
        return carts + machine.cart_offsets_m, pose[:, None, :3] + arms, arms

    return place


@pytest.fixture(scope="session")
def statics(joints) -> Callable[..., np.ndarray]:
    """Give a function that computes H of (1)-(2), shape (n, 6, 6), from `joints`."""

    def matrix(machine: Machine, pose: np.ndarray, q_m: np.ndarray) -> np.ndarray:
        carts, platform, arms = joints(machine, pose, q_m)
        u = (platform - carts) / np.linalg.norm(platform - carts, axis=2, keepdims=True)
        return np.concatenate([u, np.cross(arms, u)], axis=2).transpose(0, 2, 1)

    return matrix


@pytest.fixture(scope="session")
def assert_rules(joints, statics) -> Callable[[Config, Machine, Route], None]:
    """Give a check that knows only the rules a route has to keep, and nothing of how it was found."""

    def check(config: Config, machine: Machine, route: Route) -> None:
        pose, q, grid = route.pose, route.q_m, config.route.grid
        assert len(route) <= config.route.step_budget
        for index, end in ((0, config.task.start), (-1, config.task.goal)):
            tilts = np.deg2rad([end.rx_deg, end.rz_deg])
            np.testing.assert_allclose(pose[index, [0, 1, 2, 3, 5]], [end.x_m, end.y_m, end.z_m, *tilts], atol=1e-12)
            assert route.mode_names[index] == end.mode
        # (13)-(17)
        tilt_steps = np.deg2rad([grid.rx_step_deg, grid.rz_step_deg])
        largest = [config.route.x_step_m, grid.y_m.step, grid.z_m.step, *tilt_steps]
        moved = np.abs(np.diff(pose[:, [0, 1, 2, 3, 5]], axis=0))
        assert (moved <= np.array(largest) + 1e-8).all()
        # (38), and C_k = 1 only where the cart is abreast of its platform joint.
        carts, platform, _ = joints(machine, pose, q)
        along = (carts - platform)[:, [0, 1, 3], 0]
        letters = np.array([list(name) for name in route.mode_names])
        at_gate = route.gates[:, None] == np.array([1, 2, 3])
        assert not ((letters[1:] != letters[:-1]) & ~at_gate[:-1]).any()
        assert (np.abs(along[at_gate]) < 1e-6).all()
        assert ((along > 0.0) == (letters == "R"))[~at_gate].all()
        # The links have their lengths, the carts are on their rails, the telescopes within their strokes.
        lengths = np.linalg.norm(platform - carts, axis=2)
        expected = np.tile(machine.lengths_m, (len(route), 1))
        expected[:, [2, 4]] = q[:, 3:]
        np.testing.assert_allclose(lengths, expected, atol=1e-9)
        limits = np.vstack([machine.travel_m, machine.strokes_m])
        assert ((q >= limits[:, 0] - 1e-9) & (q <= limits[:, 1] + 1e-9)).all()
        assert np.rad2deg(np.abs(pose[:, [3, 5]])).max() <= config.task.tilt_max_deg + 1e-9
        # The objective, with the true kappa, the same sign of det H everywhere, and the goal reached once.
        H = statics(machine, pose, q)
        np.testing.assert_allclose(route.kappa, np.linalg.cond(H, 2), rtol=1e-8)
        assert len(set(np.sign(np.linalg.det(H)))) == 1
        added_up = route.kappa[:-1].sum()
        if config.route.objective == "integral":
            lengths = np.linalg.norm(np.diff(pose[:, [0, 1, 2, 3, 5]], axis=0) / largest, axis=1)
            added_up = (lengths * (route.kappa[1:] + route.kappa[:-1])).sum() / 2.0
        elif config.route.objective == "time":
            added_up = (np.abs(np.diff(q, axis=0)) / machine.velocity_mps).max(axis=1).sum()
        assert route.objective == pytest.approx(added_up, abs=1e-9)
        assert (route.region[:-1] != route.region[-1]).all()

    return check
