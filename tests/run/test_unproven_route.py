"""A route that is not proven optimal: kept and marked; later stages use it only when they are told to."""

from pathlib import Path

import pytest

from pipeline.config import Config
from pipeline.errors import NoSolutionError
from pipeline.run import Stage, open_results
from pipeline.status import Status
from tests.run.fake_stages import FakeStages
from tests.run.folders import ALL, BOOKS, files, summary


@pytest.fixture
def late(stages: FakeStages) -> FakeStages:
    """Let the search end with a route of 125, and a bound of 100."""
    stages.route_status, stages.objective = Status.UNPROVEN, 125.0
    return stages


def test_the_run_stops_with_the_route_kept(tmp_path: Path, fast_config: Config, late: FakeStages) -> None:
    """Cost, bound and gap are told, the route is a result marked as what it is, and nothing came after it."""
    with pytest.raises(
        NoSolutionError, match=r"not proven optimal: .* 125\.000; none has less than 100\.000"
    ) as caught:
        late.run(fast_config, tmp_path)
    assert caught.value.exit_code == 1
    assert "gap of 20.00%" in caught.value.reason
    assert "route.time_limit_s" in caught.value.advice
    assert "--unproven" in caught.value.advice
    assert str(tmp_path / "route.csv") in caught.value.__notes__[0]
    assert files(tmp_path) == BOOKS | {"regions.npz", "route.npz", "route.csv"}
    told = summary(tmp_path)
    assert told["route"]["status"] == "not proven optimal"
    assert told["route"]["gap"] == pytest.approx(0.2)
    assert told["path"] == {"status": "skipped"}
    assert open_results(tmp_path, Stage.ROUTE).route.status is Status.UNPROVEN


def test_told_to_the_run_goes_on_without_another_search(tmp_path: Path, fast_config: Config, late: FakeStages) -> None:
    """It takes the route that is there; asked again without being told to, it stops again and loses nothing."""
    with pytest.raises(NoSolutionError):
        late.run(fast_config, tmp_path)
    late.taken()
    late.run(fast_config, tmp_path, unproven=True)
    assert late.taken() == ALL[2:]
    with pytest.raises(NoSolutionError, match="not proven optimal"):
        late.run(fast_config, tmp_path)
    assert late.taken() == []
    assert "trajectory.csv" in files(tmp_path)


def test_the_stages_before_it_do_not_ask(tmp_path: Path, fast_config: Config, late: FakeStages) -> None:
    """A run that ends at the regions never comes to it, and one that ends at the route stops there all the same."""
    late.run(fast_config, tmp_path, last=Stage.REGIONS)
    with pytest.raises(NoSolutionError, match="not proven optimal"):
        late.run(fast_config, tmp_path, last=Stage.ROUTE)
    assert late.run(fast_config, tmp_path, last=Stage.ROUTE, unproven=True).outcomes[-1].outcome == "unchanged"
