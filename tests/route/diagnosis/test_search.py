"""What prevents a route."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pipeline.config import Config
from pipeline.config.file import load_config
from pipeline.errors import InfeasibleError, NoSolutionError
from pipeline.limits import Relaxation, relaxations
from pipeline.machine import build_machine
from pipeline.progress import Monitor
from pipeline.route import build_regions, plan_route
from pipeline.route.bounds.shortest_paths import fewest_positions
from pipeline.route.diagnosis.budgets import least_budget
from pipeline.route.diagnosis.relaxed_table import SearchOutcome, search_whole
from pipeline.route.diagnosis.result import InfeasibilityReport, Verdict
from pipeline.route.diagnosis.search import explain_infeasibility, reached, relax_limit
from pipeline.route.diagnosis.threshold import FeasibilityThreshold, find_threshold
from pipeline.route.moves.candidates import find_moves
from tests.conftest import CONFIGS, WITHOUT_FORCE_LIMITS


@pytest.fixture(scope="module")
def coarse(vary) -> Config:
    """Take tiny.yaml with a tilt grid of 10 degrees and (5): a route exists with 10 degrees of tilt, in 8 positions."""
    tilts = {"route.grid.rx_step_deg": 10, "route.grid.rz_step_deg": 10, "task.tilt_max_deg": 10}
    return vary(load_config(CONFIGS / "tiny.yaml"), WITHOUT_FORCE_LIMITS | tilts | {"route.objective": "sum"})


def explain(config: Config, without: str = "nothing") -> InfeasibilityReport:
    """Ask why there is no route, having made sure that there is none; limits with a word in their key are left out."""
    machine = build_machine(config.machine)
    regions = build_regions(config, machine)
    with pytest.raises(NoSolutionError):
        plan_route(config, machine, regions)
    limits = [limit for limit in relaxations(config, machine) if without not in limit.key]
    return explain_infeasibility(config, machine, regions, limits=limits)


def relaxation_of(config: Config, key: str) -> Relaxation:
    """Pick the first relaxation with a key."""
    return next(found for found in relaxations(config, build_machine(config.machine)) if found.key == key)


def ignore(message: str, fraction: float | None = None) -> None:
    """Listen to nothing."""


class TestFindThreshold:
    """The bisection over whole searches."""

    @given(st.integers(1, 60), st.integers(0, 70), st.integers(1, 70), st.integers(0, 5))
    def test_least_value_that_opens(self, first: int, more: int, opens_at: int, luck: int) -> None:
        """With tries enough it finds the first value that opens, whatever hints the routes give."""
        end = first + 1 + more

        def attempt(i: int) -> SearchOutcome:
            assert first <= i < end
            return SearchOutcome(float(i), enough=max(first, i - luck)) if i >= opens_at else SearchOutcome(None)

        threshold = find_threshold(FeasibilityThreshold(first - 1, by_graph=True), first, end, attempt, tries=100)
        if opens_at >= end:
            assert (threshold.refused, threshold.opened) == (end - 1, None)
        else:
            least = max(first, opens_at)
            assert (threshold.refused, threshold.opened, threshold.objective) == (least - 1, least, float(least))
            assert threshold.by_graph == (opens_at <= first)

    def test_tries_run_out(self) -> None:
        """Then what is proven and what was found stand apart, and both hold."""
        threshold = find_threshold(
            FeasibilityThreshold(0, by_graph=True), 1, 1000, lambda i: SearchOutcome(1.0 if i >= 400 else None), tries=4
        )
        assert threshold.refused < 400 <= (threshold.opened or 0)
        assert threshold.opened != threshold.refused + 1

    def test_undecided_searches_prove_nothing(self) -> None:
        """A search that was cut short moves the bisection on, not what is refused."""
        threshold = find_threshold(
            FeasibilityThreshold(0, by_graph=True), 1, 9, lambda i: SearchOutcome(1.0 if i >= 5 else None, proven=False)
        )
        assert (threshold.refused, threshold.by_graph, threshold.opened) == (0, True, 5)


class TestGraph:
    """What the graph alone tells."""

    @pytest.mark.parametrize("seed", range(20))
    def test_reached_as_by_hand(self, seed: int, random_problem) -> None:
        """The marked regions are those that following moves one by one leads to."""
        regions, moves, _ = random_problem(seed)
        pairs = set(zip(moves.source.tolist(), moves.target.tolist(), strict=True))
        for root, backwards in ((regions.start, False), (regions.goal, True)):
            found = {root}
            for _ in range(len(regions)):
                found |= {j for i, j in pairs if i in found} if not backwards else {i for i, j in pairs if j in found}
            assert set(np.flatnonzero(reached(moves, len(regions), root, backwards))) == found


class TestFindings:
    """Findings on real tasks."""

    @pytest.mark.parametrize("tilt", [0, 5])
    def test_least_tilt(self, coarse: Config, vary, tilt: int) -> None:
        """Without tilt there is no route; 10 degrees is the least on this grid, and the route is plan_route's own."""
        config = vary(coarse, {"task.tilt_max_deg": tilt})
        finding = relax_limit(config, build_machine(config.machine), relaxation_of(config, "task.tilt_max_deg"), ignore)
        assert (finding.verdict, finding.configured, finding.value) == (Verdict.OPENS, tilt, 10.0)
        assert finding.exact
        machine = build_machine(coarse.machine)
        best = plan_route(coarse, machine, build_regions(coarse, machine))
        assert finding.objective == pytest.approx(best.objective)

    def test_step_budget(self, coarse: Config, vary) -> None:
        """Where only the step budget is too small, the least one is named, and nothing else helps."""
        found = explain(vary(coarse, {"route.step_budget": 4}), without="kappa")
        (opening,) = found.opening
        assert (opening.key, opening.value, opening.refused, opening.exact) == ("route.step_budget", 8, 7, True)
        assert {finding.verdict for finding in found.findings} == {Verdict.OPENS, Verdict.NEVER}
        assert found.from_start.all() == found.to_goal.all()
        assert (found.from_start & found.to_goal).sum() > 1000
        assert found.remarks == ()

    def test_way_along_x(self, coarse: Config, vary) -> None:
        """The way along X asks for positions, too: one more than the steps it takes."""
        config = vary(coarse, {"task.start.x_m": 1.3, "task.goal.x_m": 0.75, "route.x_step_m": 0.05})
        regions, machine = build_regions(config, build_machine(config.machine)), build_machine(config.machine)
        moves = find_moves(config, machine, regions)
        assert least_budget(config, regions, moves) == 12

    def test_ends_off_the_grid(self, coarse: Config, vary) -> None:
        """Nothing helps, proven by the graph, and the remarks say why."""
        found = explain(vary(coarse, {"route.grid.y_m": {"min": 0.7, "max": 0.9, "step": 0.2}}), without="kappa")
        assert {finding.verdict for finding in found.findings} == {Verdict.NEVER}
        assert all(finding.by_graph for finding in found.findings)
        assert [remark.split(" is ")[0] for remark in found.remarks] == ["task.start.y_m", "task.goal.y_m"]
        assert found.from_start.sum() == found.to_goal.sum() == 1

    @pytest.mark.parametrize(
        ("key", "limit", "wanted"),
        [
            ("route.kappa_max", 24.0, "more"),
            ("machine.clearance.link_link_m", 0.083, "less"),
            ("refine.travel_margin_m", 0.4, "less"),
            ("refine.stroke_margin_m", 0.14, "less"),
        ],
    )
    def test_threshold_of_the_graph(
        self, coarse: Config, vary, monkeypatch: pytest.MonkeyPatch, key: str, limit: float, wanted: str
    ) -> None:
        """The value named joins the ends in the graph of a table built with it; the one refused does not."""

        def joined(value: float) -> bool:
            config = vary(coarse, {key: value})
            machine = build_machine(config.machine)
            regions = build_regions(config, machine)
            fewest = fewest_positions(regions, find_moves(config, machine, regions))
            return fewest is not None and fewest <= config.route.step_budget

        class Found:
            objective, region = 1.0, np.array([0])

        config = vary(coarse, {key: limit})
        finding = relax_limit(
            config, build_machine(config.machine), relaxation_of(config, key), ignore, lambda *args: (Found, True)
        )
        assert finding.value is not None
        assert (finding.value > limit) == (wanted == "more")
        assert finding.exact
        assert finding.by_graph
        assert joined(finding.value)
        assert not joined(finding.refused)

    def test_undecided(self, coarse: Config, vary) -> None:
        """Searches that run out of time open nothing and prove nothing."""
        config = vary(coarse, {"task.tilt_max_deg": 0})
        tilt = relaxation_of(config, "task.tilt_max_deg")
        finding = relax_limit(config, build_machine(config.machine), tilt, ignore, lambda *args: (None, False))
        assert (finding.verdict, finding.value, finding.refused) == (Verdict.UNDECIDED, None, 0.0)

    def test_whole_search_without_route(self, coarse: Config, vary) -> None:
        """A search that finds nothing says whether that is proven: here the graph has no way."""
        config = vary(coarse, {"task.tilt_max_deg": 0})
        machine = build_machine(config.machine)
        assert search_whole(config, machine, build_regions(config, machine), ignore) == (None, True)

    def test_table_that_does_not_fit(self, coarse: Config, vary) -> None:
        """A generous table beyond the memory allowed leaves the limit undecided."""
        config = vary(coarse, {"task.tilt_max_deg": 0, "route.memory_gb": 1e-6})
        finding = relax_limit(config, build_machine(config.machine), relaxation_of(config, "task.tilt_max_deg"), ignore)
        assert (finding.verdict, finding.refused) == (Verdict.UNDECIDED, 0.0)

    def test_more_tilt_after_a_table_without_route(self, coarse: Config, vary) -> None:
        """Where the searches on one table refuse, the next larger one is looked at."""

        class Found:
            objective, region = 1.0, np.array([0])

        def search(config: Config, *args: object) -> tuple[type[Found] | None, bool]:
            return (Found, True) if config.task.tilt_max_deg >= 30.0 else (None, True)

        config = vary(coarse, {"task.tilt_max_deg": 0})
        tilt = relaxation_of(config, "task.tilt_max_deg")
        finding = relax_limit(config, build_machine(config.machine), tilt, ignore, search)
        assert (finding.value, finding.refused, finding.exact, finding.by_graph) == (30.0, 20.0, True, False)

    def test_unlocking_at_the_tilt_of_an_end(self, coarse: Config, vary) -> None:
        """A start tilted by as much as a step of the freed axis: that much may do, and is looked at."""
        config = vary(coarse, {"task.locked_axes": ["rx"], "task.start.rz_deg": 10.0})
        limits = relaxations(config, build_machine(config.machine))
        finding = relax_limit(
            config, build_machine(config.machine), next(found for found in limits if found.locked_axes == ()), ignore
        )
        assert (finding.value, finding.refused) == (10.0, 0.0)
        freed = vary(config, {"task.locked_axes": []})
        machine = build_machine(freed.machine)
        best = plan_route(freed, machine, build_regions(freed, machine))
        assert finding.objective == pytest.approx(best.objective)

    def test_any_route_counts(self, coarse: Config, vary) -> None:
        """Whatever alternative and objective are asked for, the best sum alone tells if there is a route."""
        seen = []
        config = vary(coarse, {"route.alternative": 3, "route.objective": "bottleneck", "route.formulation": "paper"})
        search_whole(
            config, build_machine(config.machine), None, ignore, plan=lambda config, *args: seen.append(config.route)
        )
        (options,) = seen
        assert (options.alternative, options.objective, options.formulation) == (1, "sum", "core")

    def test_no_more_positions_than_there_may_be(self, coarse: Config, vary) -> None:
        """With the largest step budget there is none to try."""
        config = vary(coarse, {"route.step_budget": 500})
        machine = build_machine(config.machine)
        found = explain_infeasibility(config, machine, build_regions(config, machine), limits=[])
        assert found.findings == ()
        assert found.advice.startswith("no single change")

    def test_budgets_cannot_matter_where_nothing_joins_the_ends(self, coarse: Config, vary) -> None:
        """Without tilt there is no way at any cost: neither positions nor mode changes are varied."""
        config = vary(coarse, {"task.tilt_max_deg": 0, "task.budget.mode_changes": 3})
        machine = build_machine(config.machine)
        found = explain_infeasibility(config, machine, build_regions(config, machine), limits=[])
        assert [finding.key for finding in found.findings] == []

    @pytest.mark.parametrize(
        ("budget", "configured", "value", "refused"), [("mode_changes", 2, 3.0, 2.0), ("travel_m", 0.3, None, None)]
    )
    def test_budgets_are_varied(
        self, coarse: Config, vary, budget: str, configured: float, value: float | None, refused: float | None
    ) -> None:
        """The value named was tried, and the one refused is proven not to be enough: planning says the same."""
        config = vary(coarse, {f"task.budget.{budget}": configured})
        found = explain(config, without=".")
        finding = next(finding for finding in found.findings if finding.key == f"task.budget.{budget}")
        assert finding.verdict is Verdict.OPENS
        assert finding.value == (value or finding.value)
        assert finding.refused == (refused or finding.refused)
        assert finding.advice in found.advice
        machine = build_machine(config.machine)
        regions = build_regions(config, machine)
        wide = vary(config, {f"task.budget.{budget}": finding.value})
        assert plan_route(wide, machine, regions).objective == pytest.approx(finding.objective)
        with pytest.raises(InfeasibleError):
            plan_route(vary(config, {f"task.budget.{budget}": finding.refused}), machine, regions)

    def test_boxes_and_visits_are_removed_one_by_one(self, coarse: Config, vary) -> None:
        """Of three boxes one is in the way: without it, and without all of them, there is a route."""
        wall, aside = {"y_m": [-0.2, 1.2], "z_m": [0.55, 0.75]}, {"y_m": [0.85, 0.9], "z_m": [0.5, 0.6]}
        config = vary(coarse, {"task.avoid": [aside, wall, aside], "route.avoid_margin": 0.1})
        limits = [limit for limit in relaxations(config, build_machine(config.machine)) if limit.removes]
        machine = build_machine(config.machine)
        found = explain_infeasibility(config, machine, build_regions(config, machine), limits=limits)
        assert [finding.key for finding in found.opening] == ["task.avoid", "task.avoid[1]"]
        assert found.advice.endswith("remove task.avoid; remove task.avoid[1]")
        assert [finding.sentence.partition(",")[0] for finding in found.findings[1:]] == [
            "without task.avoid[0]: no route either (proven over all moves between regions)",
            "without task.avoid[1]: a route exists",
            "without task.avoid[2]: no route either (proven over all moves between regions)",
        ]

    def test_a_visit_that_takes_too_many_positions(self, coarse: Config, vary) -> None:
        """Of two visits the far one is named, beside the positions it takes; the near one is not."""
        near, far = {"box": {"y_m": [0.2, 0.6]}}, {"box": {"y_m": [0.05, 0.15], "z_m": [1.05, 1.1]}, "modes": ["LLL"]}
        found = explain(vary(coarse, {"task.visit": [near, far]}), without=".")
        assert [finding.advice for finding in found.opening] == [
            "set route.step_budget to 11",
            "remove task.visit",
            "remove task.visit[1]",
        ]

    def test_an_interrupt_keeps_what_was_found(self, coarse: Config, vary) -> None:
        """What was tried is there, and what was not is named."""
        config = vary(coarse, {"task.tilt_max_deg": 0})
        machine = build_machine(config.machine)
        limits = [limit for limit in relaxations(config, machine) if "kappa" not in limit.key][:3]

        def progress(message: str, fraction: float | None = None) -> None:
            if message.startswith("why not: 2 of 3"):
                raise KeyboardInterrupt

        regions = build_regions(config, machine)
        found = explain_infeasibility(config, machine, regions, Monitor(progress), limits=limits)
        assert [finding.key for finding in found.findings] == [limits[0].key]
        assert found.not_tried == tuple(limit.key for limit in limits[1:])
        assert "run again" in found.advice

    @pytest.mark.slow
    @pytest.mark.parametrize("changes", [{"task.tilt_max_deg": 5}, {"task.locked_axes": ["rx", "rz"]}])
    def test_the_task_of_the_paper(self, quick_config: Config, vary, changes: dict[str, object]) -> None:
        """At 0.1 m and 10 degrees a tilt of 10 degrees opens the way from LLL to RRR; nothing but tilt does."""
        found = explain(vary(quick_config, WITHOUT_FORCE_LIMITS | changes))
        assert {finding.key for finding in found.opening} == {"task.tilt_max_deg"}
        assert found.opening[-1].value == 10.0
        assert found.opening[-1].objective == pytest.approx(365.0, abs=0.1)
        assert found.opening[-1].exact
