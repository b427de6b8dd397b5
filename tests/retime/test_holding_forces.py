"""Whether the machine can be held and moved at all: reported with the pose, and with advice that can help there."""

from dataclasses import replace

import numpy as np
import pytest

from pipeline.errors import NoSolutionError
from pipeline.refine.result import Path
from pipeline.retime.holding_forces import require_standing
from pipeline.retime.path_dynamics import evaluate_dynamics, grid, tabulate_dynamics
from pipeline.retime.quantities import at_rest
from pipeline.retime.way_back import reversed_path


def _with(path: Path, force_n: np.ndarray | None = None, friction_n: float = 0.0, load_kg: float = 0.0) -> Path:
    masses = replace(path.machine.masses, friction_n=np.full(5, friction_n), load_kg=load_kg)
    force = path.machine.force_n if force_n is None else force_n
    return replace(path, machine=replace(path.machine, masses=masses, force_n=force))


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
    with pytest.raises(NoSolutionError, match="against gravity and dry friction alone, however slowly it moves") as e:
        require_standing(tabulate_dynamics(_with(path, limit, friction_n=60.0), grid(2_001)))
    assert "just to hold" not in e.value.reason
    assert "machine.dynamics.friction" in e.value.advice
    require_standing(tabulate_dynamics(_with(path, limit, friction_n=5.0), grid(2_001)))


def test_friction_helps_to_go_down(path: Path) -> None:
    """Where a drive gives way to gravity, friction carries a part."""
    rubbing = evaluate_dynamics(_with(path, friction_n=20.0), np.linspace(0.0, 1.0, 2_001))
    enough = 1.001 * np.abs(at_rest(rubbing)["force"]).max(axis=0)
    require_standing(tabulate_dynamics(_with(path, enough, friction_n=20.0), grid(2_001)))
