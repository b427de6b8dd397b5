"""The way back where friction makes it harder: timed by itself, or told to be impossible."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from pipeline.config import Config, RetimeConfig
from pipeline.errors import NoSolutionError
from pipeline.refine.result import Path
from pipeline.retime import measure_usage, retime_path, way_back
from pipeline.retime.path_dynamics import path_terms


def _config(config: Config, **options: Any) -> Config:
    return config.model_copy(update={"retime": RetimeConfig(jerk=False, **options)})


@pytest.fixture(scope="module")
def needed(path: Path) -> dict[str, np.ndarray]:
    """Forces of the drives against gravity and friction, there and back."""
    rubbing = _rubbing(path, np.full(5, 2_000.0))
    terms = path_terms(rubbing, np.linspace(0.0, 1.0, 2_001))
    gravity, friction = terms.c[:, :5], terms.friction()
    return {"there": np.abs(gravity + friction).max(axis=0), "back": np.abs(gravity - friction).max(axis=0)}


def _rubbing(path: Path, force_n: np.ndarray) -> Path:
    masses = replace(path.machine.masses, friction_n=np.full(5, 60.0))
    return replace(path, machine=replace(path.machine, masses=masses, force_n=force_n))


def _weak(path: Path, needed: dict[str, np.ndarray], part: float) -> tuple[Path, int]:
    """Limit the drive for which the way back is hardest to what it needs there (0) to what it needs back (1)."""
    drive = int(np.argmax(needed["back"] / needed["there"]))
    assert needed["back"][drive] > 1.02 * needed["there"][drive]
    force = np.full(5, 2_000.0)
    force[drive] = (1.0 - part) * needed["there"][drive] + part * needed["back"][drive]
    return _rubbing(path, force), drive


def test_an_impossible_way_back_is_told_as_such(
    agder_config: Config, path: Path, needed: dict[str, np.ndarray]
) -> None:
    """There it goes; of the way back is told that it is that, s along the way there, and that it is not holding."""
    weak, drive = _weak(path, needed, 0.5)
    config = _config(agder_config)
    there = retime_path(config, weak)
    with pytest.raises(
        NoSolutionError, match=r"^retime: on the way back, .* against gravity and dry friction"
    ) as caught:
        way_back(config, there)
    terms = path_terms(weak, np.linspace(0.0, 1.0, 2_001))
    back = np.abs(terms.c[:, :5] - terms.friction())[:, drive]
    assert caught.value.diagnosis["s"] == pytest.approx(terms.s[np.argmax(back)], abs=1e-3)
    assert "hold" not in caught.value.reason


@pytest.mark.parametrize("speed", [1.0, 0.5])
def test_a_way_back_that_would_be_far_too_slow_is_timed_by_itself(
    agder_config: Config, path: Path, needed: dict[str, np.ndarray], speed: float
) -> None:
    """Drives that can hardly move back somewhere are waited for there, and not everywhere; limits and dwells hold."""
    weak, _ = _weak(path, needed, 1.0005)
    config = _config(agder_config, speed=speed, dwell_s=(0.5, 0.2))
    there = retime_path(config, weak)
    back = way_back(config, there)
    assert back.dwell_s == there.dwell_s[::-1]
    assert there.motion_s < back.motion_s < 1.3 * there.motion_s
    assert measure_usage(back, 0.01).largest <= 1.001
    assert back.q(0.0) == pytest.approx(there.q(there.duration_s))
    assert back.q(back.duration_s) == pytest.approx(there.q(0.0))
