"""Milder values of the limits, and the regions each of them admits."""

from dataclasses import replace

import numpy as np
import pytest

from pipeline.config import Config
from pipeline.config.file import load_config
from pipeline.limits import Relaxation, relaxations
from pipeline.limits.actuators import TRAVEL_KEY
from pipeline.limits.holding_force import FORCES_KEY
from pipeline.machine import build_machine
from pipeline.route import build_regions
from tests.conftest import CONFIGS


@pytest.fixture(scope="module")
def config(vary) -> Config:
    """Take tiny.yaml with rails that bind, rails that are checked and a finer tilt grid."""
    changes = {
        "route.grid.rx_step_deg": 10,
        "route.grid.rz_step_deg": 15,
        "task.tilt_max_deg": 12,
        "task.start.x_m": 1.3,
        "task.goal.x_m": 0.75,
        "machine.clearance.link_rail_m": 0.01,
        "machine.limits.holding_fraction": 0.4,
        "refine.travel_margin_m": 0.05,
        "refine.stroke_margin_m": 0.12,
        "machine.dynamics.friction": {"carts_n": 20.0, "telescopes_n": 10.0},
    }
    rails = {f"machine.rails.{k}.travel_m": [0.25, 1.8] for k in range(3)}
    return vary(load_config(CONFIGS / "tiny.yaml"), changes | rails)


def by_key(config: Config) -> dict[str, Relaxation]:
    """Return the relaxations by key, the last of several."""
    return {relaxation.key: relaxation for relaxation in relaxations(config, build_machine(config.machine))}


@pytest.mark.parametrize(
    ("key", "widest", "value"),
    [
        ("task.tilt_max_deg", 20.0, 15.0),
        ("task.tilt_max_deg", 20.0, 12.0),
        ("route.kappa_max", 1000.0, 130.0),
        ("machine.clearance.link_link_m", 0.0, 0.06),
        ("machine.clearance.link_rail_m", 0.0, 0.45),
        ("machine.limits.holding_fraction", 1.0, 0.45),
        (FORCES_KEY, 10.0, 1.2),
        ("refine.travel_margin_m", 0.0, 0.03),
        ("refine.stroke_margin_m", 0.0, 0.1),
        (TRAVEL_KEY, 1.0, 0.05),
        (TRAVEL_KEY, 1.0, 0.0),
    ],
)
def test_a_cut_table_is_the_table_built_with_the_value(config: Config, key: str, widest: float, value: float) -> None:
    """Every row and every column: the generous table cut down is what build_regions computes."""
    relaxation = by_key(config)[key]
    generous = relaxation.change(widest)
    wide = build_regions(generous, build_machine(generous.machine))
    samples = wide.samples(build_machine(config.machine))
    windows, inside = relaxation.prepare(samples, wide.x_window_m)(value)
    cut = replace(wide, x_window_m=windows).take(inside)
    changed = relaxation.change(value)
    built = build_regions(changed, build_machine(changed.machine))
    assert len(wide) > len(built) > 0
    assert len(cut) == len(built)
    for column in ("controlled", "ry_rad", "modes", "gates", "q_m", "kappa", "x_window_m"):
        order = [np.lexsort((*t.controlled[:-2].T.round(9), t.modes[:-2], t.gates[:-2])) for t in (cut, built)]
        ours, theirs = (getattr(t, column)[rows] for t, rows in zip((cut, built), order, strict=True))
        np.testing.assert_allclose(ours, theirs, atol=1e-9)
        np.testing.assert_allclose(getattr(cut, column)[-2:], getattr(built, column)[-2:])


def test_values_become_milder(config: Config) -> None:
    """The first is the configured one, the others go one way up to the bound."""
    for relaxation in by_key(config).values():
        assert relaxation.levels[0] == relaxation.configured
        steps = np.diff(relaxation.levels)
        falls = "clearance" in relaxation.key or "margin" in relaxation.key
        assert (steps < 0.0).all() if falls else (steps > 0.0).all()
        assert relaxation.segments[-1] == len(relaxation.levels)
        assert list(relaxation.segments) == sorted(set(relaxation.segments))


def test_tilts_are_those_of_the_grid(config: Config) -> None:
    """Multiples of either tilt step above the limit, up to the bound."""
    assert by_key(config)["task.tilt_max_deg"].levels.tolist() == [12.0, 15.0, 20.0, 30.0, 40.0, 45.0]


def test_a_locked_axis_is_unlocked(config: Config, vary) -> None:
    """Each locked axis alone, then both; tilts begin with what the ends need."""
    both = relaxations(vary(config, {"task.locked_axes": ["rx", "rz"]}), build_machine(config.machine))
    tilts = [relaxation for relaxation in both if relaxation.key == "task.tilt_max_deg"]
    assert [relaxation.locked_axes for relaxation in tilts] == [("rz",), ("rx",), ()]
    assert tilts[0].levels.tolist() == [0.0, 10.0, 20.0, 30.0, 40.0]
    assert tilts[0].change(10.0).task.locked_axes == ("rz",)
    one = relaxations(
        vary(config, {"task.locked_axes": ["rx"], "task.start.rz_deg": 5.0}), build_machine(config.machine)
    )
    tilts = [relaxation for relaxation in one if relaxation.key == "task.tilt_max_deg"]
    assert [relaxation.locked_axes for relaxation in tilts] == [None, ()]
    assert tilts[0].levels.tolist() == [12.0, 15.0, 30.0, 45.0]
    assert tilts[1].levels[:4].tolist() == [0.0, 5.0, 10.0, 15.0]


def test_unlocking_needs_the_tilts_of_visits(config: Config, vary) -> None:
    """No value is below the tilt of a pose to visit, but the one known not to be enough."""
    pose = {"x_m": 1.0, "y_m": 0.3, "z_m": 0.9, "rx_deg": 0.0, "rz_deg": 12.0, "mode": "LLL"}
    locked = vary(config, {"task.locked_axes": ["rx"], "task.visit": [{"pose": pose}]})
    (freed,) = (found for found in relaxations(locked, build_machine(locked.machine)) if found.locked_axes == ())
    assert freed.levels[:3].tolist() == [0.0, 12.0, 15.0]


@pytest.mark.parametrize(
    ("configured", "first", "last"), [(30.5, 31.0, 1e3), (100.0, 101.0, 1e3), (990.0, 991.0, 9.9e3), (1e10, None, 1e11)]
)
def test_values_of_kappa_are_whole_then_geometric(config: Config, vary, configured, first, last) -> None:
    """Whole numbers up to 1,000, then a thousand per decade, up to ten times the cap however large that is."""
    levels = by_key(vary(config, {"route.kappa_max": configured}))["route.kappa_max"].levels
    assert levels[1] == first or levels[1] == pytest.approx(10.0**0.001 * configured)
    assert levels[-1] == pytest.approx(last)
    assert len(levels) <= 2_001
    assert (np.diff(levels) > 0.0).all()
    assert (np.diff(levels[1:]) <= np.maximum(1.0, 0.00231 * levels[1:-1]) + 1e-9).all()


def test_what_refuses_nothing_is_left_out(config: Config, vary) -> None:
    """No clearance or margin asked for, rails unchecked, the largest tilt there is: these cannot be the reason."""
    changes = {
        "refine.travel_margin_m": 0.0,
        "refine.stroke_margin_m": 0.0,
        "machine.clearance.link_link_m": 0.0,
        "machine.clearance.link_rail_m": None,
        "task.tilt_max_deg": 85.0,
        "machine.limits.carts.force_n": None,
        "machine.limits.telescopes.force_n": None,
        "machine.limits.link_force_n": None,
    }
    assert set(by_key(vary(config, changes))) == {"route.kappa_max", TRAVEL_KEY}
