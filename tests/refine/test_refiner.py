"""Stage two as a whole."""

import signal
import threading
from dataclasses import replace

import numpy as np
import pytest

from pipeline.config import Config
from pipeline.errors import ConfigError, NoSolutionError
from pipeline.machine import Machine, build_machine
from pipeline.progress import Monitor
from pipeline.refine import Path, PathFigures, Refinement, coarse_path, measure_path, refine_path, sample_path
from pipeline.refine.check import Violation, find_violations
from pipeline.refine.problem import MeshSolution, Problem, build_problem
from pipeline.refine.refiner import MeshRefinement, advise_on_directions, find_first_path, repair_between_nodes
from pipeline.route import Route, build_regions, plan_route
from pipeline.route.metric import step_sizes
from pipeline.status import Status


@pytest.fixture(scope="module")
def samples(refinement: Refinement):
    """Sample the refined path where nothing was checked before."""
    return sample_path(refinement.path, np.sort(np.random.default_rng(5).uniform(0.0, 1.0, 10_000)))


def test_it_is_better_than_the_coarse_path(refinement: Refinement, steps: np.ndarray, samples) -> None:
    """Less integral of kappa, less length and no larger kappa; how much less, where the route minimised the same."""
    coarse = measure_path(sample_path(refinement.coarse, np.linspace(0.0, 1.0, 10_000)), steps)
    fine = measure_path(samples, steps)
    assert fine.kappa_integral < 0.87 * coarse.kappa_integral
    assert fine.kappa_max <= coarse.kappa_max
    assert fine.length < coarse.length


def test_it_keeps_every_limit_between_the_nodes(refinement: Refinement, machine: Machine, samples) -> None:
    """One sign of det H, clearance, tilt, strokes and travel at 10,000 places that were not samples before."""
    assert refinement.status is Status.CONVERGED
    assert len(set(samples.det_sign.tolist())) == 1
    assert samples.link_distance_m.min() >= 0.03
    assert np.rad2deg(np.abs(samples.pose[:, [3, 5]]).max()) <= 30.0
    limits = machine.actuator_limits_m
    assert (samples.q_m >= limits[:, 0]).all()
    assert (samples.q_m <= limits[:, 1]).all()


def test_it_begins_and_ends_exactly_where_the_route_does(refinement: Refinement, route: Route) -> None:
    """Start and goal are hit up to rounding."""
    ends = refinement.path.q(np.array([0.0, 1.0]))
    np.testing.assert_allclose(ends, route.q_m[[0, -1]], rtol=0.0, atol=1e-15)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("refine", "close"),
    [
        ({"corridor_cells": 1.0}, 1e-6),
        # With room IPOPT finds two optima of the first mesh, one in each direction, and meshes differ by some nodes:
        # integrals are 0.02 % apart without a corridor, 0.03 % in the default's.
        ({"corridor": "free"}, 1e-3),
        ({}, 1e-3),
    ],
    ids=["narrow", "free", "default"],
)
def test_the_route_backwards_gives_the_same_path(
    light_config: Config, machine: Machine, route: Route, steps: np.ndarray, refine: dict[str, object], close: float
) -> None:
    """Nothing in the program knows a direction: figures are the same, and meshes that follow the difficulty."""
    options = light_config.refine.model_copy(update={"max_meshes": 3, **refine})
    config = light_config.model_copy(update={"refine": options})
    fields = ("region", "modes", "gates", "visits", "pose", "q_m", "kappa")
    flipped = replace(route, **{name: getattr(route, name)[::-1] for name in fields})
    there, back = (refine_path(config, machine, way) for way in (route, flipped))
    assert back.meshes == there.meshes
    assert back.nodes == pytest.approx(there.nodes, rel=0.1 if close > 1e-6 else 0.0)
    assert back.meshes > 1
    one, other = (
        measure_path(sample_path(result.path, np.linspace(0.0, 1.0, 2_000)), steps) for result in (there, back)
    )
    assert other.kappa_integral == pytest.approx(one.kappa_integral, rel=close)
    assert other.modes == one.modes[::-1]


def test_too_few_iterations_end_with_what_is_violated(light_config: Config, machine: Machine, route: Route) -> None:
    """A failed solve is reported as failed, with the last iterate kept."""
    short = light_config.refine.model_copy(update={"max_iterations": 2})
    with pytest.raises(NoSolutionError, match="Maximum_Iterations_Exceeded") as caught:
        refine_path(light_config.model_copy(update={"refine": short}), machine, route)
    assert caught.value.diagnosis["status"] == "not converged"
    assert np.shape(caught.value.diagnosis["coefficients"]) == (22, 5)


def test_a_broken_requirement_adds_nodes_and_is_reported_if_it_stays(
    light_config: Config, machine: Machine, route: Route
) -> None:
    """Each round has more nodes; the last one ends with what is broken and what to change."""
    seen: list[int] = []

    def broken(config: Config, route: Route, path: Path, coarse: Path) -> list[Violation]:
        seen.append(len(path.node_s))
        return [Violation("links too close, metres", 0.01, np.array([0.305]), "Raise refine.nodes.")]

    few = light_config.refine.model_copy(update={"max_rounds": 2})
    problem = build_problem(light_config.model_copy(update={"refine": few}), machine, route)
    first = MeshRefinement(find_first_path(problem), 1, None)
    with pytest.raises(NoSolutionError, match="links too close") as caught:
        repair_between_nodes(problem, first, check=broken)
    # Half-way between two nodes there is an evaluation point.
    assert seen == [2 * 50 - 1, 2 * 51 - 1]
    assert "refine.nodes" in caught.value.advice


def test_ctrl_c_during_ipopt_is_raised_again(light_config: Config, machine: Machine, route: Route) -> None:
    """CasADi swallows interrupts; here one ends the solve, and the handler is put back."""
    before = signal.getsignal(signal.SIGINT)

    def interrupt(message: str, fraction: float | None = None) -> None:
        if "iteration 3" in message:
            signal.raise_signal(signal.SIGINT)

    with pytest.raises(KeyboardInterrupt):
        refine_path(light_config, machine, route, Monitor(interrupt))
    assert signal.getsignal(signal.SIGINT) is before


def test_it_works_in_another_thread(light_config: Config, machine: Machine, route: Route) -> None:
    """Outside the main thread there are no signals to note."""
    short = light_config.refine.model_copy(update={"max_iterations": 1})
    ended: list[str] = []

    def work() -> None:
        try:
            refine_path(light_config.model_copy(update={"refine": short}), machine, route)
        except NoSolutionError as error:
            ended.append(error.stage)

    thread = threading.Thread(target=work)
    thread.start()
    thread.join()
    assert ended == ["refine"]


@pytest.mark.slow
def test_the_reference_machine_keeps_its_figures(agder_config: Config, machine: Machine) -> None:
    """A tenth less integral of kappa, no larger kappa, and the surrogate within 1 % of the true one.

    A route that minimises the integral leaves less to gain than one of the least sum, but a better path.
    """
    route = plan_route(agder_config, machine, build_regions(agder_config, machine))
    result = refine_path(agder_config, machine, route)
    steps = step_sizes(agder_config.route)
    coarse, fine = (
        measure_path(sample_path(path, np.linspace(0.0, 1.0, 10_001)), steps) for path in (result.coarse, result.path)
    )
    assert fine.kappa_integral < 0.9 * coarse.kappa_integral
    assert fine.kappa_integral < 650.0
    assert fine.kappa_max <= coarse.kappa_max
    assert result.surrogate_integral == pytest.approx(fine.kappa_integral, rel=0.01)
    assert fine.measures["min_link_distance_m"] >= 0.03
    assert fine.det_sign_constant
    assert fine.measures["max_tilt_deg"] <= 30.0
    assert fine.closure_residual_m < 1e-9


@pytest.mark.slow
@pytest.mark.parametrize("axis", ["rx", "rz"])
def test_a_locked_axis_stays_locked(light_config: Config, machine: Machine, axis: str) -> None:
    """The 4-DOF machines reconfigure, their locked axis within its tolerance."""
    task = light_config.task.model_copy(update={"locked_axes": (axis,)})
    config = light_config.model_copy(update={"task": task})
    route = plan_route(config, machine, build_regions(config, machine))
    path = refine_path(config, machine, route).path
    column = {"rx": 3, "rz": 5}[axis]
    tilt = np.rad2deg(np.abs(path.pose(np.linspace(0.0, 1.0, 5_000))[:, column]).max())
    assert tilt <= light_config.refine.lock_tolerance_deg


@pytest.mark.slow
@pytest.mark.parametrize(
    ("section", "change"),
    [
        ("task", {"tilt_max_deg": 10.0}),
        ("machine.clearance", {"link_rail_m": 0.45}),
    ],
)
def test_other_limits_are_kept_as_well(light_config: Config, section: str, change: dict[str, float]) -> None:
    """With less tilt or with rails to keep clear of the path improves on the route, within the limits."""
    document = light_config.model_dump(mode="json")
    part = document
    for key in section.split("."):
        part = part[key]
    part.update(change)
    config = Config.model_validate(document)
    machine, steps = build_machine(config.machine), step_sizes(config.route)
    result = refine_path(config, machine, plan_route(config, machine, build_regions(config, machine)))
    coarse, fine = (
        measure_path(sample_path(path, np.linspace(0.0, 1.0, 10_001)), steps) for path in (result.coarse, result.path)
    )
    assert fine.kappa_integral < coarse.kappa_integral
    assert fine.kappa_max <= coarse.kappa_max
    assert fine.measures["max_tilt_deg"] <= config.task.tilt_max_deg
    assert fine.measures["min_rail_distance_m"] >= (config.machine.clearance.link_rail_m or 0.0)
    assert fine.det_sign_constant


def test_a_short_task_is_refined_quickly(light_config: Config, machine: Machine) -> None:
    """Two moves in one working mode: nothing but a nearly straight line, found in a few iterations."""
    document = light_config.model_dump(mode="json")
    document["task"]["goal"].update(mode="LLL", y_m=0.5)
    config = Config.model_validate(document)
    route = plan_route(config, machine, build_regions(config, machine))
    result = refine_path(config, machine, route)
    assert result.rounds == 1
    assert result.iterations < 60


@pytest.mark.slow
def test_every_objective_is_best_at_its_own(
    light_config: Config, machine: Machine, route: Route, bottleneck: Route
) -> None:
    """The least integral, the least largest kappa, and between; from the bottleneck route that gets lower still."""

    def refined(objective: str, along: Route) -> PathFigures:
        refine = light_config.refine.model_copy(update={"objective": objective})
        config = light_config.model_copy(update={"refine": refine})
        path = refine_path(config, machine, along).path
        return measure_path(sample_path(path, np.linspace(0.0, 1.0, 5_001)), step_sizes(config.route))

    integral, mixed, maximum = (refined(objective, route) for objective in ("integral", "mixed", "maximum"))
    assert integral.kappa_integral < mixed.kappa_integral < maximum.kappa_integral
    assert integral.kappa_max > mixed.kappa_max > maximum.kappa_max
    best = refined("maximum", bottleneck)
    assert best.kappa_max < maximum.kappa_max
    coarse = coarse_path(machine, bottleneck, step_sizes(light_config.route))
    highest = float(sample_path(coarse, np.linspace(0.0, 1.0, 5_001)).kappa.max())
    assert best.kappa_max < 0.99 * highest
    # Between the points at which it is kept below that, kappa may be a little higher.
    assert refined("integral", bottleneck).kappa_max <= highest * (1.0 + 1e-4)


@pytest.fixture(scope="module")
def bottleneck(quick_config: Config, machine: Machine) -> Route:
    """Plan the route of least largest kappa."""
    config = quick_config.model_copy(
        update={"route": quick_config.route.model_copy(update={"objective": "bottleneck"})}
    )
    return plan_route(config, machine, build_regions(config, machine))


def test_where_ipopt_fails_the_path_comes_from_another_start(
    light_config: Config, machine: Machine, route: Route, refinement: Refinement, steps: np.ndarray
) -> None:
    """The descent from the coarse path ends within one per cent of the usual one, every limit kept."""

    def fail(problem: Problem, initial: MeshSolution) -> MeshSolution:
        raise NoSolutionError("refine", "IPOPT gave up", "Try again.")

    usual = measure_path(sample_path(refinement.path, np.linspace(0, 1, 2_000)), steps)
    heard: list[str] = []
    monitor = Monitor(lambda message, fraction=None: heard.append(message))
    problem = build_problem(light_config, machine, route, monitor)
    path = find_first_path(problem, minimise=fail).path
    assert any("IPOPT gave up; trying another start" in message for message in heard)
    figures = measure_path(sample_path(path, np.linspace(0.0, 1.0, 2_000)), steps)
    assert figures.kappa_integral == pytest.approx(usual.kappa_integral, rel=0.01)
    assert find_violations(light_config, route, path, problem.coarse) == []


def test_where_no_start_leads_to_a_path_both_failures_are_reported(
    light_config: Config, machine: Machine, route: Route
) -> None:
    """What IPOPT said first, with its advice and diagnosis, then why the other start failed."""

    def fail(problem: Problem, initial: MeshSolution) -> MeshSolution:
        raise NoSolutionError("refine", "IPOPT gave up", "Try again.", {"status": "time limit"})

    short = light_config.refine.model_copy(update={"max_iterations": 1})
    problem = build_problem(light_config.model_copy(update={"refine": short}), machine, route)
    with pytest.raises(NoSolutionError, match="IPOPT gave up; from another start, kappa was still falling") as caught:
        find_first_path(problem, minimise=fail)
    assert (caught.value.advice, caught.value.diagnosis) == ("Try again.", {"status": "time limit"})


def test_a_failure_with_a_direction_advises_to_leave_it_out(light_config: Config) -> None:
    """Each configured direction is named; without one the failure stays as it is."""
    failure = NoSolutionError("refine", "nothing was found", "Raise refine.nodes.")
    assert advise_on_directions(failure, light_config) is failure
    keys = {"start_direction": (0.0, 1.0, 0.0)}
    for more, words in (({}, "refine.start_direction"), ({"goal_direction": (1.0, 0.0, 0.0)}, " and refine.goal")):
        refine = light_config.refine.model_copy(update={**keys, **more})
        advised = advise_on_directions(failure, light_config.model_copy(update={"refine": refine}))
        assert advised.advice.startswith("Raise refine.nodes. Or change refine.start_direction")
        assert words in advised.advice
        assert advised.advice.endswith(", or leave it out.")


def test_the_mesh_is_refined_until_nothing_changes(light_config: Config, machine: Machine, route: Route) -> None:
    """The last change is below the tolerance, and the nodes have become more where the path is difficult."""
    refine = light_config.refine.model_copy(update={"max_meshes": 8, "tolerance": 0.005})
    result = refine_path(light_config.model_copy(update={"refine": refine}), machine, route)
    assert 1 < result.meshes < 8
    assert result.mesh_change is not None
    assert result.mesh_change < 0.005
    assert result.nodes > 50
    assert len(result.path.spline.c) > 22


def test_a_cap_on_kappa_that_cannot_be_kept_is_reported(light_config: Config, machine: Machine, route: Route) -> None:
    """One below kappa at the start is refused; one that no path reaches is reported as the broken limit."""
    for cap, error, words in ((22.0, ConfigError, "start or the goal is 23"), (23.5, NoSolutionError, "above its cap")):
        refine = light_config.refine.model_copy(update={"kappa_max": cap, "max_rounds": 1})
        with pytest.raises(error, match=words):
            refine_path(light_config.model_copy(update={"refine": refine}), machine, route)
