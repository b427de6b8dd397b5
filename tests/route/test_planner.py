"""Stage one as a whole."""

from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pipeline.errors import InfeasibleError, NoSolutionError
from pipeline.machine import build_machine
from pipeline.progress import Monitor
from pipeline.route import build_regions, plan_route
from pipeline.route.bounds.bottleneck import least_cap
from pipeline.route.bounds.shortest_paths import shortest_paths
from pipeline.route.cost.kappa_sum import KappaSum
from pipeline.route.deadline import Deadline
from pipeline.route.moves.candidates import Moves
from pipeline.route.moves.rejections import Rejection
from pipeline.route.moves.screen import Screen
from pipeline.route.planner import chosen_route, solve_problem
from pipeline.route.problem import RouteProblem
from pipeline.route.search.optimum import prove_on_core
from pipeline.route.search.placement import rejected_moves
from pipeline.route.search.states import unexpanded_graph
from pipeline.status import Status

KAPPA = Rejection("kappa exceeds its cap", "route.kappa_max")
BOX = Rejection("the TCP enters a box to avoid", "route.avoid_margin")


def _plan(config):
    machine = build_machine(config.machine)
    return machine, plan_route(config, machine, build_regions(config, machine))


def _problem(given, config=None):
    return RouteProblem.of(config or given.config, given.machine, given.regions, given.moves)


def _prove(problem):
    graph = unexpanded_graph(problem.regions, problem.moves)
    return prove_on_core(problem, graph, shortest_paths(problem.regions, problem.moves, KappaSum()))


@pytest.fixture(scope="module")
def ten(quick_config, vary, pose_problem):
    """Make the quick task with at most 10 degrees of tilt."""
    return pose_problem(vary(quick_config, {"task.tilt_max_deg": 10}))


@pytest.fixture(scope="module")
def twenty(quick_config, vary, pose_problem):
    """Make the quick task with at most 20 degrees of tilt."""
    return pose_problem(vary(quick_config, {"task.tilt_max_deg": 20}))


def test_the_quick_task_has_a_proven_route_that_keeps_all_rules(quick, assert_rules):
    """LLL to RRR on the coarse grid, with telescope limits and rails: gap zero, rules checked independently."""
    route = plan_route(quick.config, quick.machine, quick.regions)
    assert_rules(quick.config, quick.machine, route)
    assert route.status is Status.OPTIMAL
    assert route.search.gap == 0.0
    assert route.search.bound == pytest.approx(route.objective, abs=1e-6)
    assert route.search.relaxation <= route.objective <= route.search.threshold * (1.0 + 1e-9)
    assert route.search.moves == len(quick.moves)
    assert route.kappa_max < 40.0
    assert route.mode_changes >= 3
    assert route.objective == pytest.approx(274.198822, abs=1e-6)


def test_the_reversed_task_works(quick, vary, assert_rules):
    """All-right to all-left: the same way back costs the same but for the ends."""
    config = vary(quick.config, {"task.start.mode": "RRR", "task.goal.mode": "LLL"})
    swapped = np.append(np.arange(len(quick.regions) - 2), [quick.regions.goal, quick.regions.start])
    route = plan_route(config, quick.machine, quick.regions.take(swapped))
    assert_rules(config, quick.machine, route)
    assert route.mode_names[0] == "RRR"
    assert route.objective == pytest.approx(273.460101, abs=1e-6)


@pytest.mark.parametrize(
    ("key", "value", "least"),
    [("tilt_max_deg", 10, 364.992), ("locked_axes", ["rx"], 338.896), ("locked_axes", ["rz"], 412.190)],
)
def test_less_tilt_or_a_locked_axis_still_leaves_a_route(quick_config, vary, assert_rules, key, value, least):
    """The 4-DOF machines of the paper's outlook reconfigure, and so does 10 degrees of tilt: at no less cost."""
    config = vary(quick_config, {f"task.{key}": value})
    machine, route = _plan(config)
    assert_rules(config, machine, route)
    assert route.objective >= least - 1e-3


def test_moves_that_fail_when_followed_are_forbidden_and_counted(twenty, assert_rules):
    """With 20 degrees of tilt the first routes do not hold; the one that does costs more than the relaxation."""
    seen = []
    monitor = Monitor(lambda message, fraction=None: seen.append(message))
    route = plan_route(twenty.config, twenty.machine, twenty.regions, monitor)
    assert_rules(twenty.config, twenty.machine, route)
    assert 0 < route.search.forbidden_moves < route.search.followed_moves
    assert route.search.relaxation == pytest.approx(311.625, abs=1e-3)
    assert route.objective > route.search.relaxation
    rounds = [message for message in seen if message.startswith("route: round")]
    assert len(rounds) == route.search.rounds
    assert rounds[0] == "route: round 1, 0 moves forbidden"


def test_the_least_largest_kappa_is_known_to_one_per_cent(ten):
    """Against bisection over the kappa of all regions; never above that of the route itself."""
    problem = _problem(ten)
    (route,) = solve_problem(problem)
    exact = least_cap(problem.regions, problem.moves, most_moves=problem.options.step_budget - 1)
    assert exact * (1.0 - 1e-9) <= route.search.least_kappa_max <= min(1.01 * exact, route.kappa_max) * (1.0 + 1e-9)


def _failing(times):
    """Follow the moves of routes, and find the first of them in a box that many times."""
    calls = []

    def follow(problem, placed):
        calls.append(len(placed.region))
        return [(0, BOX)] if len(calls) <= times else rejected_moves(problem, placed)

    return follow, calls


def test_moves_that_only_fail_where_they_are_made_take_rounds(twenty):
    """What the cores' moves did not show at one x, the route at its own may."""
    follow, calls = _failing(2)
    route = solve_problem(_problem(twenty), follow=follow)[0]
    assert route.search.rounds == len(calls) == 3


def test_too_few_rounds_end_with_what_was_wrong_with_the_moves(twenty, vary):
    """The error counts the flaws and names the key."""
    config = vary(twenty.config, {"route.max_rounds": 2})
    with pytest.raises(NoSolutionError, match=r"after 2 rounds .* \(\d+: .*\)") as caught:
        solve_problem(_problem(twenty, config), follow=_failing(2)[0])
    assert not isinstance(caught.value, InfeasibleError)
    assert "route.max_rounds" in caught.value.advice
    assert caught.value.exit_code == 1


@pytest.mark.parametrize("tilt", [0, 5])
def test_too_little_tilt_is_proven_to_leave_no_route(quick_config, vary, tilt):
    """Not a time limit: the regions that can be reached from the start are exhausted."""
    with pytest.raises(InfeasibleError, match=r"no route exists on these .* \(proven by exhausting them\)") as caught:
        _plan(vary(quick_config, {"task.tilt_max_deg": tilt}))
    assert caught.value.stage == "route"
    assert "task.tilt_max_deg" in caught.value.advice
    assert caught.value.diagnosis["status"] == "infeasible"
    assert 0 < caught.value.diagnosis["reached"] < caught.value.diagnosis["regions"]


@pytest.mark.parametrize(
    ("found", "words"), [(1, "there is only 1 route that strays"), (2, "are only 2 routes that stray ")]
)
def test_too_few_routes_are_counted(quick_config, vary, found, words):
    """An alternative of a rank beyond what there is."""
    config = vary(quick_config, {"route.alternative": 3})
    with pytest.raises(InfeasibleError, match=words) as caught:
        chosen_route(config.route, [None] * found)
    assert caught.value.diagnosis == {"status": "infeasible", "routes": found}


def test_start_and_goal_without_a_grid_between_them_have_no_route(quick_config, vary):
    """An empty table ends in the same proof."""
    config = vary(quick_config, {"route.grid.y_m": {"min": 5, "max": 5.1, "step": 0.1}, "task.tilt_max_deg": 0})
    with pytest.raises(InfeasibleError, match="no route exists on these 2 regions"):
        _plan(config)


def test_a_step_budget_too_small_names_the_one_that_is_needed(quick, vary, assert_rules):
    """Eleven moves need twelve positions: with eleven there is an error that says so, with twelve a route."""
    with pytest.raises(InfeasibleError, match="at least 12 positions") as caught:
        plan_route(vary(quick.config, {"route.step_budget": 11}), quick.machine, quick.regions)
    assert caught.value.diagnosis["fewest_positions"] == 12
    assert "12" in caught.value.advice
    config = vary(quick.config, {"route.step_budget": 12})
    route = plan_route(config, quick.machine, quick.regions)
    assert_rules(config, quick.machine, route)
    assert len(route) == 12


def test_x_that_takes_more_steps_than_there_are_is_proven_impossible(quick_config, vary):
    """From x 1.6 to 0.2 at 2 cm a step: no threshold helps, and the error says that x or the budget is at fault."""
    values = {
        "task.start.x_m": 1.6,
        "task.goal.x_m": 0.2,
        "route.x_step_m": 0.02,
        "route.step_budget": 13,
        "task.tilt_max_deg": 10,
    }
    with pytest.raises(InfeasibleError, match=r"within the step budget and the travel along X .*proven") as caught:
        _plan(vary(quick_config, values))
    assert "x_step_m" in caught.value.advice


def test_too_little_time_to_find_a_route_is_reported_as_such(quick, vary):
    """Not as a proof: with what is proven, and the key to change."""
    config = vary(quick.config, {"route.time_limit_s": 1e-6})
    with pytest.raises(NoSolutionError, match=r"no route was found within .* at least 2\d\d\.\d+ \(proven\)") as caught:
        plan_route(config, quick.machine, quick.regions)
    assert not isinstance(caught.value, InfeasibleError)
    assert caught.value.diagnosis["status"] == "time limit"
    assert "route.time_limit_s" in caught.value.advice


@dataclass(frozen=True)
class SolversWithoutTime(Deadline):
    """A clock that gives everything its time but the solver."""

    @property
    def left_s(self) -> float:
        """None."""
        return 0.0


@pytest.mark.parametrize("objective", ["sum", "bottleneck"])
def test_the_best_route_so_far_is_the_answer_when_the_time_is_up(twenty, vary, assert_rules, objective):
    """It keeps all rules, is not called optimal, and lies above a bound that the optimum keeps."""
    config = vary(twenty.config, {"route.objective": objective})
    problem = replace(_problem(twenty, config), deadline=SolversWithoutTime(1.0, np.inf))
    route = solve_problem(problem)[0]
    assert_rules(config, twenty.machine, route)
    assert route.status is Status.UNPROVEN
    best = solve_problem(_problem(twenty, config))[0]
    assert best.status is Status.OPTIMAL
    assert route.search.bound <= best.objective <= route.objective + 1e-9
    assert route.search.gap == pytest.approx(1.0 - route.search.bound / route.objective)


def test_a_budget_of_travel_that_is_all_but_used_up(quick, vary, assert_rules):
    """1.3571 m is the least that a route needs, and the same route is the best with 1.36 m: found, and proven."""
    config = vary(quick.config, {"task.budget.travel_m": 1.36})
    route = plan_route(config, quick.machine, quick.regions)
    assert_rules(config, quick.machine, route)
    assert (route.status, route.search.solver) == (Status.OPTIMAL, "label setting")
    assert route.objective == pytest.approx(481.819769)
    assert 1.35 < np.abs(np.diff(route.pose[:, :3], axis=0)).sum() <= 1.36


@pytest.mark.parametrize("margin", [1e-12, 0.05])
def test_the_first_guess_of_the_threshold_does_not_change_the_optimum(ten, vary, margin):
    """Too low and it is raised until the proof holds, too high and the core is only larger than need be."""
    config = vary(ten.config, {"route.threshold_margin": margin})
    route = plan_route(config, ten.machine, ten.regions)
    usual = plan_route(ten.config, ten.machine, ten.regions)
    assert route.objective == pytest.approx(usual.objective, abs=1e-9)
    assert route.objective <= route.search.threshold * (1.0 + 1e-9)


def test_a_sequence_that_breaks_the_rules_is_never_handed_on(ten):
    """Should a solver ever return one, as here for moves of other steps, the error says which rules it breaks."""
    problem = _problem(ten)
    shorter = replace(problem, steps=problem.steps * [1.0, 0.9, 1.0, 1.0, 1.0])
    with pytest.raises(
        NoSolutionError, match=r"breaks the rules: \(14\): the move after step \d+ is too long"
    ) as caught:
        solve_problem(shorter)
    assert caught.value.diagnosis["status"] == "not converged"
    assert all(rule.startswith("(14)") for rule in caught.value.diagnosis["broken"])


@pytest.fixture(scope="module")
def hand_config(quick_config, vary):
    """Let a step of x be one metre, as random problems want it."""

    def configure(positions, **more):
        return vary(quick_config, {"route.x_step_m": 1.0, "route.step_budget": positions} | more)

    return configure


@settings(max_examples=40)
@given(
    st.integers(0, 1_000_000),
    st.floats(0.0, 0.6),
    st.sampled_from([1e-6, 0.002, 1.0]),
    st.sampled_from([0.0, 0.5, 1.0]),
)
def test_the_optimum_over_moves_that_hold_is_found_for_any_flaws(
    random_problem, hand_config, machine, cheapest, seed, share, margin, ahead
):
    """Moves are forbidden only when a route uses them; the sum is that of a dynamic program that knows all flaws."""
    regions, moves, positions = random_problem(seed)
    random = np.random.default_rng(seed)
    bad = {
        frozenset((i, j))
        for i, j in zip(moves.source.tolist(), moves.target.tolist(), strict=True)
        if random.random() < share
    }
    good = np.array(
        [frozenset(pair) not in bad for pair in zip(moves.source.tolist(), moves.target.tolist(), strict=True)],
        dtype=bool,
    )
    expected = cheapest(regions, Moves(moves.source[good], moves.target[good]), positions, 1.0)

    def follow(problem, placed):
        rows = placed.region.tolist()
        return [(step, KAPPA) for step, pair in enumerate(pairwise(rows)) if frozenset(pair) in bad]

    def follow_some(source, target):
        # What is not found ahead of time is found when the route is followed.
        flawed = [frozenset(pair) in bad for pair in zip(source.tolist(), target.tolist(), strict=True)]
        return [KAPPA if flaw and random.random() < ahead else None for flaw in flawed]

    config = hand_config(positions, **{"route.threshold_margin": margin})
    # Rows are a metre of y apart: the other steps do not apply to made-up regions.
    problem = replace(RouteProblem.of(config, machine, regions, moves), steps=np.array([1.0, 1e3, 1e3, 1e3, 1e3]))
    screen = Screen(follow_some, len(regions))
    if np.isfinite(expected):
        route = solve_problem(problem, screen=screen, follow=follow)[0]
        assert route.objective == pytest.approx(expected, abs=1e-6)
        assert route.search.gap == 0.0
        assert ahead < 1.0 or route.search.rounds == 1
    else:
        with pytest.raises(InfeasibleError, match="proven"):
            solve_problem(problem, screen=screen, follow=follow)


@pytest.fixture(scope="module")
def across(cross_config, vary, pose_problem):
    """Make the task that x binds: from 1.6 to 0.2, on rails of 2.1 m."""
    rails = {f"machine.rails.{k}.travel_m": [0.0, 2.1] for k in range(3)}
    return pose_problem(vary(cross_config, rails | {"task.start.x_m": 1.6, "task.goal.x_m": 0.2}))


@pytest.mark.slow
def test_a_detour_forced_by_x_is_proven_optimal(across, cheapest, assert_rules):
    """328.695121 before moves are followed, as a dynamic program over cost and reachable x finds, too."""
    assert _prove(_problem(across)).objective == pytest.approx(328.695121, abs=1e-6)
    assert cheapest(across.regions, across.moves, 25, 0.1, cap=328.8) == pytest.approx(328.695121, abs=1e-6)
    route = plan_route(across.config, across.machine, across.regions)
    assert_rules(across.config, across.machine, route)
    assert route.objective == pytest.approx(328.901367, abs=1e-6)
    assert np.ptp(route.pose[:, 0]) >= 1.4


@pytest.mark.slow
def test_the_reference_task_is_proven_at_full_size(agder_config, assert_rules):
    """0.06 m and 5 degrees: more than 150,000 regions, within 25 positions, kappa below 40."""
    machine = build_machine(agder_config.machine)
    regions = build_regions(agder_config, machine)
    assert len(regions) >= 150_000
    route = plan_route(agder_config, machine, regions)
    assert_rules(agder_config, machine, route)
    assert route.search.gap == 0.0
    assert route.kappa_max < 40.0
