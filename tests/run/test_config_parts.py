"""The part of the configuration that each stage reads."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from pipeline.config import Config
from pipeline.machine import Machine
from pipeline.run.config_parts import regions_part
from pipeline.run.stage_specs import SPECS, spec_of
from pipeline.stage import Stage

Change = Callable[..., Config]


class Recorder:
    """Stands for an object and notes which of its leaves are read."""

    def __init__(self, target: Any, read: set[str], path: str = "") -> None:
        self._target, self._read, self._path = target, read, path

    def __getattr__(self, name: str) -> Any:
        value = getattr(self._target, name)
        path = f"{self._path}.{name}".lstrip(".")
        if hasattr(type(value), "model_fields"):
            return Recorder(value, self._read, path)
        self._read.add(path)
        return value


def declared(config: Config, stage: Stage, path: str) -> bool:
    """Check whether a key is part of what a stage may read, or is written nowhere while it has its default."""
    return found(spec_of(SPECS, stage).config_part(config), path) or not found(config.model_dump(mode="json"), path)


def found(part: Any, path: str) -> bool:
    """Check whether a key is in nested sections."""
    for key in path.split("."):
        if not isinstance(part, dict) or key not in part:
            return not isinstance(part, dict)
        part = part[key]
    return True


@pytest.mark.slow
def test_stages_read_only_what_they_declare(quick_config: Config, machine: Machine, change: Change) -> None:
    """The real stages read no key that their fingerprint leaves out; one that does would keep stale results."""
    from dataclasses import replace

    from pipeline.refine import refine_path
    from pipeline.route import build_regions, plan_route

    config = change(quick_config, refine__nodes=40, refine__coefficients=16)
    nothing = np.full(5, np.nan)
    slow = replace(machine, acceleration_mps2=nothing, jerk_mps3=nothing)
    blind = replace(slow, velocity_mps=nothing)
    results: list[Any] = []
    for stage, make in (
        (Stage.REGIONS, lambda config: build_regions(config, blind)),
        (Stage.ROUTE, lambda config: plan_route(config, blind, results[0])),
        (Stage.REFINE, lambda config: refine_path(config, slow, results[1])),
    ):
        read: set[str] = set()
        results.append(make(Recorder(config, read)))
        assert read
        # How much memory may be used decides how, not what.
        read.discard("route.memory_gb")
        assert [path for path in sorted(read) if not declared(config, stage, path)] == []


def test_bodies_and_obstacles_count_where_there_are_any(bodies_config: Config, vary: Any) -> None:
    """They are left out of what is written where there are none."""
    ball = {"name": "ball", "hull": {"points_m": [[0.0, -1.0, 0.0]], "radius_m": 0.1}}
    config = vary(bodies_config, {"task.obstacles": [ball]})
    for stage in (Stage.REGIONS, Stage.ROUTE, Stage.REFINE, Stage.CERTIFY):
        for path in ("machine.bodies", "machine.link_bodies", "task.obstacles"):
            assert found(spec_of(SPECS, stage).config_part(config), path)
        assert not found(spec_of(SPECS, stage).config_part(bodies_config), "task.obstacles")


def test_config_parts_grow(fast_config: Config) -> None:
    """Every stage depends on what the stage it builds on depends on, so that no change gets lost."""

    def leaves(value: Any, path: str = "") -> set[str]:
        if isinstance(value, dict):
            return {leaf for key, item in value.items() for leaf in leaves(item, f"{path}.{key}")}
        return {path}

    for spec in SPECS:
        for earlier in spec.upstream:
            part = spec_of(SPECS, earlier).config_part(fast_config)
            assert leaves(part) <= leaves(spec.config_part(fast_config))


@pytest.mark.parametrize(
    ("key", "value", "counts"),
    [
        ("machine__limits__telescopes__force_n", 900.0, True),
        ("machine__limits__link_force_n", 900.0, True),
        ("machine__limits__holding_fraction", 0.5, True),
        ("machine__limits__gravity_stiffness_npm", -9_000.0, True),
        ("machine__dynamics__load_kg", 5.0, True),
        ("machine__dynamics__friction__carts_n", 5.0, True),
        ("machine__dynamics__platform__inertia_kgm2", (0.2, 0.2, 0.2), False),
        ("machine__limits__carts__force_n", {"push": 400.0, "pull": 300.0}, True),
        ("machine__characteristic_length_m", 0.9, True),
        ("refine__travel_margin_m", 0.004, True),
        ("refine__stroke_margin_m", 0.001, True),
        ("machine__limits__carts__jerk_mps3", 20.0, False),
        ("machine__limits__tcp__speed_mps", 0.2, False),
    ],
)
def test_planning_depends_on_what_holds_the_machine(fast_config: Config, change: Change, key, value, counts) -> None:
    """Regions, route and path depend on forces that hold the machine and on margins; other limits cost a trajectory."""
    for stage in (Stage.REGIONS, Stage.ROUTE, Stage.REFINE):
        part = spec_of(SPECS, stage).config_part
        assert (part(change(fast_config, **{key: value})) != part(fast_config)) is counts


@pytest.mark.parametrize(
    ("key", "value"),
    [
        ("machine__limits__carts__jerk_mps3", 20.0),
        ("machine__limits__tcp__speed_mps", 0.2),
        ("machine__dynamics__platform__inertia_kgm2", (0.2, 0.2, 0.2)),
        ("retime__jerk", False),
    ],
)
def test_a_path_with_its_time_law_depends_on_all_that_limits_it(
    fast_config: Config, change: Change, key, value
) -> None:
    """Limits of motion, masses, and whether jerk is limited at all; for other paths they cost a trajectory."""
    part = spec_of(SPECS, Stage.REFINE).config_part
    for objective, counts in (("time", True), ("integral", False)):
        config = change(fast_config, refine__objective=objective)
        assert (part(change(config, **{key: value})) != part(config)) is counts


def test_velocity_limits_cost_a_new_path_only_where_it_is_smooth(fast_config: Config, change: Change) -> None:
    """Regions and route never depend on them."""
    faster = {"machine__limits__telescopes__velocity_mps": 0.2}
    for stage in (Stage.REGIONS, Stage.ROUTE, Stage.REFINE):
        part = spec_of(SPECS, stage).config_part
        for config, counts in (
            (fast_config, stage is Stage.REFINE),
            (change(fast_config, refine__smoothness=0.0), False),
        ):
            assert (part(change(config, **faster)) != part(config)) is counts


def test_directions_count_for_the_route_with_an_approach_only(fast_config: Config, change: Change) -> None:
    """Without one they are the path's alone; the approach counts for regions and route."""
    ahead = change(fast_config, refine__start_direction=(0.0, 1.0, 0.0))
    straight = change(ahead, refine__approach_m=0.05)
    for stage in (Stage.REGIONS, Stage.ROUTE):
        part = spec_of(SPECS, stage).config_part
        assert part(ahead) == part(fast_config)
        assert part(straight) != part(ahead)
        assert part(change(straight, refine__start_direction=(0.0, 0.0, 1.0))) != part(straight)


def test_without_force_limits_masses_do_not_count(fast_config: Config, change: Change) -> None:
    """Then nothing has to be held, and another load costs no new plan."""
    forces = ("carts__force_n", "telescopes__force_n", "link_force_n")
    free = change(fast_config, **{f"machine__limits__{key}": None for key in forces})
    assert regions_part(change(free, machine__dynamics__load_kg=5.0)) == regions_part(free)


def test_margins_count_for_the_table_only_where_there_are_boxes(fast_config: Config, change: Change) -> None:
    """They are counted in grid steps and steps along X."""
    for avoid, counts in (([], False), ([{"y_m": [5.0, 6.0]}], True)):
        base = change(fast_config, task__avoid=avoid)
        for key, value in (("route__avoid_margin", 1.0), ("route__x_step_m", 0.2)):
            other = change(base, **{key: value})
            same = regions_part(other) == regions_part(base)
            assert same is not counts
