"""Whether the machine can be held and moved at all: reported with the pose, and with advice that can help there."""

from dataclasses import replace

import numpy as np
import pytest

from pipeline.errors import NoSolutionError
from pipeline.refine.result import Path
from pipeline.retime.holding_forces import require_ends_held, require_standing, resting_forces
from pipeline.retime.path_dynamics import evaluate_dynamics, grid, tabulate_dynamics
from pipeline.retime.quantities import at_rest
from pipeline.retime.way_back import reversed_path


def _with(path: Path, force_n: np.ndarray | None = None, friction_n: float = 0.0, load_kg: float = 0.0) -> Path:
    masses = replace(path.machine.masses, friction_n=np.full(5, friction_n), load_kg=load_kg)
    force = path.machine.force_n if force_n is None else force_n
    return replace(path, machine=replace(path.machine, masses=masses, force_n=force))


def test_resting_forces_are_those_of_the_path(path: Path) -> None:
    """The same numbers as along the path, at one of its places."""
    s = np.array([0.3])
    found, dynamics = resting_forces(path.machine, path.pose(s), path.q(s)[:, :3]), evaluate_dynamics(path, s)
    assert found["force"] == pytest.approx(dynamics.c[:, :5])
    assert found["link_force"] == pytest.approx(dynamics.c[:, 5:])
    assert resting_forces(replace(path.machine, masses=None), path.pose(s), path.q(s)[:, :3]) == {}


@pytest.mark.parametrize(("places", "end"), [([0.0, 0.5], "start"), ([0.5, 0.0], "goal")])
def test_a_load_too_heavy_for_an_end_asks_for_another_end(path: Path, places: list[float], end: str) -> None:
    """Another path does not help where the machine cannot even begin: nothing is said of kappa."""
    s = np.array(places)
    force = np.abs(resting_forces(path.machine, path.pose(s), path.q(s)[:, :3])["force"])
    # A limit between what the two poses need, of the drive for which the end in question is the harder one.
    row = ("start", "goal").index(end)
    drive = int(np.argmax(force[row] - force[1 - row]))
    limit = np.full(5, np.inf)
    limit[drive] = force[:, drive].mean()
    machine = replace(path.machine, force_n=limit)
    with pytest.raises(NoSolutionError, match=f"just to hold the machine at the {end}, .*at the pose x ") as caught:
        require_ends_held(machine, path.pose(s), path.q(s)[:, :3])
    assert caught.value.advice.endswith(f"give the task another {end}.")
    require_ends_held(replace(machine, force_n=np.full(5, np.inf)), path.pose(s), path.q(s)[:, :3])


def test_on_the_way_back_the_place_is_that_along_the_way_there(path: Path) -> None:
    """There and back, the force is too large at the same pose, so that s is the same, too."""
    c = np.abs(evaluate_dynamics(path, np.linspace(0.0, 1.0, 2_001)).c[:, :5]).max(axis=0)
    ends = np.abs(evaluate_dynamics(path, np.array([0.0, 1.0])).c[:, :5]).max(axis=0)
    drive = int(np.argmax(c / ends))
    limit = np.full(5, np.inf)
    limit[drive] = (c[drive] + ends[drive]) / 2.0
    weak = _with(path, limit)
    places = []
    for way, backwards in ((weak, False), (reversed_path(weak), True)):
        with pytest.raises(NoSolutionError, match="just to hold the machine at s = ") as caught:
            require_standing(tabulate_dynamics(way, grid(2_001)), backwards)
        assert "kappa_max" in caught.value.advice
        places.append(caught.value.diagnosis["s"])
    assert places[0] == pytest.approx(places[1], abs=1e-4)


def test_with_friction_it_is_not_called_holding(path: Path) -> None:
    """Gravity alone is within the limit; what is too much is to move against friction."""
    limit = np.abs(evaluate_dynamics(path, np.linspace(0.0, 1.0, 2_001)).c[:, :5]).max(axis=0) + 10.0
    with pytest.raises(NoSolutionError, match="against gravity and dry friction alone, however slow it moves") as e:
        require_standing(tabulate_dynamics(_with(path, limit, friction_n=60.0), grid(2_001)))
    assert "just to hold" not in e.value.reason
    assert "machine.dynamics.friction" in e.value.advice
    require_standing(tabulate_dynamics(_with(path, limit, friction_n=5.0), grid(2_001)))


def test_friction_helps_to_hold_and_to_go_down(path: Path) -> None:
    """Limits below what gravity takes are enough where friction carries the rest, at rest and on a way down."""
    s = np.array([0.0, 1.0])
    gravity = resting_forces(path.machine, path.pose(s), path.q(s)[:, :3])["force"]
    weak = _with(path, np.abs(gravity).max(axis=0) - 5.0, friction_n=10.0).machine
    require_ends_held(weak, path.pose(s), path.q(s)[:, :3])
    with pytest.raises(NoSolutionError, match="just to hold"):
        require_ends_held(_with(path, weak.force_n, friction_n=2.0).machine, path.pose(s), path.q(s)[:, :3])
    rubbing = evaluate_dynamics(_with(path, friction_n=20.0), np.linspace(0.0, 1.0, 2_001))
    enough = 1.001 * np.abs(at_rest(rubbing)["force"]).max(axis=0)
    require_standing(tabulate_dynamics(_with(path, enough, friction_n=20.0), grid(2_001)))
