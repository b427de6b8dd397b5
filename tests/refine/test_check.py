"""The check between the nodes, on samples that break one promise each."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from scipy.interpolate import make_interp_spline

from pipeline.config import Config
from pipeline.refine import Path, Refinement
from pipeline.refine import check as between_module
from pipeline.refine.check import find_violations
from pipeline.refine.measure import PathSamples, sample_path
from pipeline.route import Route

Spoil = Callable[[PathSamples], dict[str, np.ndarray]]


@pytest.fixture
def check(light_config: Config, route: Route, refinement: Refinement, monkeypatch: pytest.MonkeyPatch):
    """Give a check of the refined path with its samples spoiled."""

    def run(spoil: Spoil):
        def spoiled(path: Path, s: np.ndarray) -> PathSamples:
            samples = sample_path(path, s)
            return replace(samples, **spoil(samples))

        monkeypatch.setattr(between_module, "sample_path", spoiled)
        return find_violations(light_config, route, refinement.path, refinement.coarse)

    return run


def _from(samples: PathSamples, name: str, s: float, change: Callable[[np.ndarray], np.ndarray]) -> np.ndarray:
    """Change a column from s on."""
    changed = getattr(samples, name).copy()
    changed[samples.s >= s] = change(changed[samples.s >= s])
    return changed


def test_a_good_path_breaks_nothing(check) -> None:
    """The refined path, unspoiled, passes."""
    assert check(lambda samples: {}) == []


def test_a_change_of_the_sign_of_det_h_is_found_where_it_happens(check) -> None:
    """Nodes are wanted at the change, and not on all that follows."""
    (breach,) = check(lambda samples: {"det_sign": _from(samples, "det_sign", 0.35, np.negative)})
    assert breach.what == "det H changes sign"
    np.testing.assert_allclose(breach.s, [0.35])


def test_a_singular_sample_is_found(check) -> None:
    """Zero is no sign."""
    (breach,) = check(lambda samples: {"det_sign": _from(samples, "det_sign", 1, np.zeros_like)})
    assert breach.what == "det H changes sign"


def test_a_jump_to_another_assembly_is_found_where_it_happens(check) -> None:
    """The pose does not move by many times its usual step."""
    (breach,) = check(
        lambda samples: {"pose": _from(samples, "pose", 0.15, lambda pose: pose + [0.0, 0.0, 0.0, 0.0, 0.5, 0.0])}
    )
    assert breach.what == "the pose jumps"
    assert breach.worst == pytest.approx(0.5, abs=0.01)
    np.testing.assert_allclose(breach.s, [300 / 2_000])


def test_several_breaches_are_told_together_with_advice(check) -> None:
    """Each names its amount, its place and what to change."""
    found = check(
        lambda samples: {
            "link_distance_m": _from(samples, "link_distance_m", 0.5, lambda distance: 0.0 * distance + 0.02),
            "kappa": _from(samples, "kappa", 0.75, lambda kappa: kappa + 100.0),
        }
    )
    assert [str(breach).split(" (")[0] for breach in found] == [
        "kappa above its cap",
        "links too close, metres",
    ]
    assert "by 0.01 at worst, first at s = 0.5000" in str(found[1])
    assert "clearance_margin_m" in found[1].advice


def test_rails_count_only_where_the_machine_asks_for_it(check) -> None:
    """Without a rail clearance a link may touch a rail's line."""
    assert check(lambda samples: {"rail_distance_m": 0.0 * samples.rail_distance_m}) == []


def test_a_move_that_is_fast_is_no_jump(light_config: Config, route: Route, refinement: Refinement) -> None:
    """The same curve, run through thirty times as fast at its end as half-way, is all on one branch."""
    s = np.linspace(0.0, 1.0, 400)
    path = refinement.path
    slow = Path(path.machine, make_interp_spline(s, path.q(s**6), k=5), s, path.pose(s**6))
    found = [breach.what for breach in find_violations(light_config, route, slow, refinement.coarse)]
    assert "the pose jumps" not in found
    assert any("nearly stop" in what for what in found)
