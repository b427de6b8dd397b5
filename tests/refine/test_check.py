"""The check between the nodes, on samples that break one requirement each."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from scipy.interpolate import make_interp_spline

from pipeline.config import Config
from pipeline.limits.joint_cone import joint_angles_deg
from pipeline.refine import Path, Refinement
from pipeline.refine.check import doubtful_intervals, find_violations
from pipeline.refine.measure import PathSamples, sample_path
from pipeline.route import Route
from tests.joints import cone, with_cones

Spoil = Callable[[PathSamples], dict[str, np.ndarray]]


@pytest.fixture
def check(light_config: Config, route: Route, refinement: Refinement):
    """Give a check of the refined path with quantities of its samples spoiled."""

    def run(spoil: Spoil):
        def spoiled(path: Path, s: np.ndarray) -> PathSamples:
            samples = sample_path(path, s)
            return samples.with_known(**spoil(samples))

        return find_violations(light_config, route, refinement.path, refinement.coarse, sample=spoiled)

    return run


def _from(samples: PathSamples, name: str, s: float, change: Callable[[np.ndarray], np.ndarray]) -> np.ndarray:
    """Change a quantity from s on."""
    changed = getattr(samples, name).copy()
    changed[samples.s >= s] = change(changed[samples.s >= s])
    return changed


def test_a_good_path_breaks_nothing(check) -> None:
    """The refined path, unspoiled, passes."""
    assert check(lambda samples: {}) == []


def test_a_change_of_the_sign_of_det_h_is_found_where_it_happens(check) -> None:
    """Nodes are wanted at the change, and not on all that follows."""
    (violation,) = check(lambda samples: {"det_sign": _from(samples, "det_sign", 0.35, np.negative)})
    assert violation.what == "det H changes sign"
    np.testing.assert_allclose(violation.s, [0.35])


def test_several_violations_are_reported_together_with_advice(check) -> None:
    """Each names its amount, its place and what to change."""
    found = check(
        lambda samples: {
            "link_distances_m": _from(samples, "link_distances_m", 0.5, lambda distance: 0.0 * distance + 0.02),
            "kappa": _from(samples, "kappa", 0.75, lambda kappa: kappa + 100.0),
        }
    )
    assert [str(violation).split(" (")[0] for violation in found] == [
        "kappa above its cap",
        "links too close, metres",
    ]
    assert "by 0.01 at worst, first at s = 0.5000" in str(found[1])
    assert "clearance_margin_m" in found[1].advice


@pytest.mark.parametrize(
    ("change", "what"),
    [
        ({"task": {"tilt_max_deg": 5.0}}, "tilt too large"),
        ({"route": {"kappa_max": 25.0}}, "kappa above"),
        ({"task": {"locked_axes": ("rz",)}}, "tilt too large"),
    ],
)
def test_each_violation_of_the_configuration_is_found(
    light_config: Config, route: Route, refinement: Refinement, change: dict[str, dict[str, object]], what: str
) -> None:
    """Stricter limits than the path was made for are noticed."""
    sections = {name: getattr(light_config, name).model_copy(update=values) for name, values in change.items()}
    found = find_violations(light_config.model_copy(update=sections), route, refinement.path, refinement.coarse)
    assert [what in violation.what for violation in found] == [True]


@pytest.mark.parametrize(
    ("change", "what"),
    [
        ({"link_link_m": 0.05}, "links too close"),
        ({"link_rail_m": 0.6}, "too close to a rail"),
        ({"strokes_m": np.array([[0.95, 1.1], [1.05, 1.4]])}, "beyond stroke"),
    ],
)
def test_each_violation_of_the_machine_is_found(
    light_config: Config, route: Route, refinement: Refinement, change: dict[str, object], what: str
) -> None:
    """Stricter clearances and strokes than the path was made for are noticed."""
    path = replace(refinement.path, machine=replace(refinement.path.machine, **change))
    found = find_violations(light_config, route, path, refinement.coarse)
    assert [what in violation.what for violation in found] == [True]


def test_a_joint_that_leaves_its_cone_between_samples_is_found(
    light_config: Config, route: Route, refinement: Refinement
) -> None:
    """At no sample of the even grid, and by less than a thousandth of a degree: in between, at its largest angle."""
    grid = np.linspace(0.0, 1.0, light_config.refine.check_points + 1)
    one = cone("3b", "cart", (0.0, 0.41, 0.91), 90.0)
    seen = joint_angles_deg(one, sample_path(refinement.path, grid))
    near = grid[seen.argmax()] + np.linspace(-grid[1], grid[1], 2_001)
    most, largest = float(seen.max()), float(joint_angles_deg(one, sample_path(refinement.path, near)).max())
    assert most < largest < most + 1e-3
    for half_angle_deg, words in (((most + largest) / 2.0, ["cart joint of link 3b"]), (largest + 1e-6, [])):
        machine = with_cones(refinement.path.machine, replace(one, half_angle_deg=half_angle_deg))
        found = find_violations(light_config, route, replace(refinement.path, machine=machine), refinement.coarse)
        assert [str(violation)[:21] for violation in found] == words
        assert all(abs(violation.s[0] - grid[seen.argmax()]) < grid[1] for violation in found)


def test_a_path_that_cannot_close_is_a_violation(light_config: Config, route: Route, refinement: Refinement) -> None:
    """Lost closure is reported with the place."""
    spline = refinement.path.spline
    far = replace(refinement.path, spline=type(spline)(spline.t, spline.c + [0.0, 0.0, 5.0, 0.0, 0.0], spline.k))
    found = find_violations(light_config, route, far, refinement.coarse)
    assert "no solution" in str(found[0])


def test_a_fast_move_is_not_a_jump(light_config: Config, route: Route, refinement: Refinement) -> None:
    """The same curve, traversed thirty times as fast at its end as half-way, is all on one branch."""
    s = np.linspace(0.0, 1.0, 400)
    path = refinement.path
    slow = Path(path.machine, make_interp_spline(s, path.q(s**6), k=5), s, path.pose(s**6))
    found = [violation.what for violation in find_violations(light_config, route, slow, refinement.coarse)]
    assert "the pose jumps" not in found
    assert any("nearly stop" in what for what in found)


EVERY = np.ones((11, 1), dtype=bool)


@pytest.mark.parametrize("rounding", [0.0, 1e-9])
def test_intervals_around_an_unseen_minimum_are_doubtful(rounding: float) -> None:
    """One margin is far above zero, the other a parabola that dips below between two samples."""
    s = np.linspace(0.0, 1.0, 11)
    margins = np.column_stack([np.ones(11), (s - 0.45) ** 2 - 1e-4])
    np.testing.assert_array_equal(np.flatnonzero(doubtful_intervals(s, margins, rounding, EVERY)), [3, 4, 5])
    assert not doubtful_intervals(s, margins + 0.1, rounding, EVERY).any()


def test_what_is_broken_already_or_has_no_bound_is_not_doubtful() -> None:
    """Below zero at a sample there is nothing more to find; infinite margins never come near zero."""
    s = np.linspace(0.0, 1.0, 11)
    margins = np.column_stack([np.full(11, -1.0), np.full(11, np.inf)])
    assert not doubtful_intervals(s, margins, 1e-9, EVERY).any()


def test_margins_that_stop_counting_between_two_samples_are_doubtful() -> None:
    """A margin falls below zero while it still counts, or only after that: which one is seen by halving."""
    s, margins = np.linspace(0.0, 1.0, 5), np.array([[0.4], [0.3], [0.05], [-0.2], [-0.4]])
    counts = np.array([[True], [True], [True], [False], [False]])
    assert np.flatnonzero(doubtful_intervals(s, margins, 1e-9, counts)).tolist() == [1, 2]
    assert not doubtful_intervals(s, margins, 1e-9, np.zeros((5, 1), dtype=bool)).any()


def test_a_short_violation_between_samples_is_found(light_config: Config, route: Route, refinement: Refinement) -> None:
    """The largest kappa, above a cap that all samples of the first grid keep, is found by halving intervals."""
    sparse = light_config.refine.model_copy(update={"check_points": 1_000})
    grid = sample_path(refinement.path, np.linspace(0.0, 1.0, 1_001))
    worst = int(grid.kappa.argmax())
    around = sample_path(refinement.path, np.linspace(grid.s[worst - 1], grid.s[worst + 1], 2_001))
    cap = (grid.kappa.max() + around.kappa.max()) / 2.0
    assert grid.kappa.max() < cap - 1e-8
    config = light_config.model_copy(
        update={"refine": sparse, "route": light_config.route.model_copy(update={"kappa_max": float(cap)})}
    )
    (violation,) = find_violations(config, route, refinement.path, refinement.coarse)
    assert violation.what == "kappa above its cap"
    assert np.abs(violation.s - grid.s[worst]).max() < 1e-3
