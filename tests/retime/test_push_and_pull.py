"""Force limits that differ for push and pull: in plans, bounds, usage and what is said of them."""

from dataclasses import replace

import numpy as np
import pytest

from pipeline.config import Config
from pipeline.errors import NoSolutionError
from pipeline.refine.result import Path
from pipeline.retime import retime_path
from pipeline.retime.constraints import limit_rows
from pipeline.retime.duration_bound import duration_bound
from pipeline.retime.fastest import plan
from pipeline.retime.holding_forces import require_standing
from pipeline.retime.path_dynamics import evaluate_dynamics, grid, tabulate_dynamics
from pipeline.retime.quantities import evaluate, fractions
from pipeline.retime.result import Trajectory
from pipeline.retime.usage import measure_usage


def _with(path: Path, push: np.ndarray, pull: np.ndarray) -> Path:
    return replace(path, machine=replace(path.machine, force_n=np.stack([push, pull])))


def _forces(trajectory: Trajectory) -> np.ndarray:
    """Evaluate the drives' forces at many instants, without anything that knows of limits. Shape (n, 5)."""
    t = np.linspace(0.0, trajectory.duration_s, 20_001)
    s, *state = (trajectory.s(t, order) for order in range(4))
    return evaluate(evaluate_dynamics(trajectory.path, s), *state)["force"]


@pytest.fixture(scope="module")
def sides(path: Path) -> tuple[np.ndarray, np.ndarray]:
    """Find limits that leave half of what the fastest motion takes beyond rest, of either sign; largest first."""
    free = plan(_with(path, np.full(5, 1e5), np.full(5, 1e5)), 500)
    used, rest = _forces(free), evaluate_dynamics(path, np.linspace(0.0, 1.0, 2_001)).c[:, :5]
    push, pull = used.max(axis=0), -used.min(axis=0)
    held = np.maximum(rest.max(axis=0), 1.0), np.maximum(-rest.min(axis=0), 1.0)
    return held[0] + 0.5 * np.maximum(push - held[0], 5.0), held[1] + 0.5 * np.maximum(pull - held[1], 5.0)


def test_each_side_keeps_its_own_limit(path: Path, sides: tuple[np.ndarray, np.ndarray]) -> None:
    """Forces reach a limit and exceed none; with the larger of both on either side it would be faster."""
    push, pull = sides
    assert (np.abs(push - pull) > 1.0).all()
    own = plan(_with(path, push, pull), 500)
    forces = _forces(own)
    shares = np.stack([forces.max(axis=0) / push, -forces.min(axis=0) / pull])
    assert shares.max() == pytest.approx(1.0, abs=1e-2)
    strongest = plan(_with(path, *[np.maximum(push, pull)] * 2), 500)
    assert strongest.duration_s * 1.001 < own.duration_s
    bound = duration_bound(tabulate_dynamics(own.path, grid(1_001)), grid(500))
    assert 0.97 * own.duration_s < bound <= own.duration_s
    usage = measure_usage(own, 0.01)
    assert usage.fractions["force"] == pytest.approx(shares.max(axis=0), rel=5e-3)


def test_exchanged_limits_are_other_limits(path: Path, sides: tuple[np.ndarray, np.ndarray]) -> None:
    """What a drive may push is not what it may pull."""
    push, pull = sides
    own = measure_usage(plan(_with(path, push, pull), 500)).fractions["force"].max()
    held = np.maximum(push, pull)
    forces = _forces(plan(_with(path, held, held), 500))
    assert own < 1.01
    assert fractions(forces, np.stack([push, pull])).max() > 1.05


@pytest.mark.slow
def test_jerk_limited_motions_keep_them(agder_config: Config, path: Path, sides: tuple[np.ndarray, np.ndarray]) -> None:
    """The whole stage, with limited jerk."""
    push, pull = sides
    trajectory = retime_path(agder_config, _with(path, push, pull))
    forces = _forces(trajectory)
    assert (forces <= 1.002 * push).all()
    assert (-forces <= 1.002 * pull).all()
    assert fractions(forces, np.stack([push, pull])).max() > 0.95


def test_rows_are_those_of_their_side(path: Path) -> None:
    """The rows of positive forces come first; each is a fraction of its own limit."""
    push, pull = np.array([100.0, 110.0, 120.0, 400.0, 410.0]), np.array([200.0, 210.0, 220.0, 500.0, 510.0])
    dynamics = evaluate_dynamics(_with(path, push, pull), np.array([0.3, 0.6]))
    rows = limit_rows(dynamics)
    those = [k for k, (name, _) in enumerate(rows.labels) if name == "force"]
    assert len(those) == 10
    np.testing.assert_allclose(rows.c[:, those[:5]] * push, dynamics.c[:, :5])
    np.testing.assert_allclose(rows.c[:, those[5:]] * pull, -dynamics.c[:, :5])


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_what_cannot_be_held_is_told_with_the_limit_of_its_side(path: Path, sign: float) -> None:
    """However strong the drive is in the other direction."""
    rest = sign * evaluate_dynamics(path, np.linspace(0.0, 1.0, 2_001)).c[:, :5]
    drive = int(np.argmax(rest.max(axis=0)))
    weak = np.full(5, 1e5)
    weak[drive] = 0.5 * rest[:, drive].max()
    push, pull = (weak, np.full(5, 1e5))[:: int(sign)]
    with pytest.raises(NoSolutionError, match=r"200\.0% of its force limit") as error:
        require_standing(tabulate_dynamics(_with(path, push, pull), grid(501)))
    assert error.value.diagnosis["limit_n"] == weak[drive]
    assert np.sign(error.value.diagnosis["force_n"]) == sign
