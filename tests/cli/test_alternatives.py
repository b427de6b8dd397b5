"""Alternatives on the command line: a run folder each, one table, and what becomes of fewer than asked for."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from typer.testing import Result

from pipeline.config import Config
from pipeline.config.file import dump_config, load_config
from pipeline.run import open_results
from pipeline.status import Status
from tests.cli.calls import invoke
from tests.run.fake_stages import FakeStages


@pytest.fixture
def alternatives(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, fast_config: Config, stages: FakeStages
) -> Callable[..., Result]:
    """Ask for alternatives, written in the folder `work`; there are three routes, and the k-th best costs 100 + k."""
    stages.routes = 3
    (tmp_path / "work").mkdir()
    monkeypatch.chdir(tmp_path / "work")
    Path("quick.yaml").write_text(dump_config(fast_config))

    def ask(*arguments: object) -> Result:
        return invoke("route", "quick.yaml", *arguments, specs=stages.specs)

    return ask


def test_each_route_has_a_folder_that_can_be_run(alternatives: Any) -> None:
    """The k-th is in DIR-k with a configuration that asks for it; a blank in DIR comes into no name of a run."""
    result = alternatives("--out", "my runs", "--alternatives", 3)
    assert result.exit_code == 0
    rows = [line for line in result.stdout.splitlines() if "my runs" in line and "Next" not in line]
    assert [row.split()[:2] for row in rows] == [["1", "101.000"], ["2", "102.000"], ["3", "103.000"]]
    assert "Next: gantry-tau run 'my runs-3/config.yaml' --out 'my runs-3', or" in result.stdout
    for rank, folder in enumerate(("my runs", "my runs-2", "my runs-3"), start=1):
        assert open_results(folder).route.objective == 100.0 + rank
        config = load_config(Path(folder) / "config.yaml")
        assert (config.route.alternative, config.name) == (rank, "quick" if rank == 1 else f"quick-{rank}")


@pytest.mark.parametrize(("out", "second"), [(".", "../work-2"), ("..", None), ("sub/..", "../work-2")])
def test_a_folder_without_a_name_takes_its_own(alternatives: Any, tmp_path: Path, out: str, second: str | None) -> None:
    """DIR-2 is beside DIR, however DIR is written."""
    Path("sub").mkdir()
    result = alternatives("--out", out, "--alternatives", 2)
    assert result.exit_code == 0
    assert (Path(second or f"{tmp_path}-2") / "route.npz").exists()


def test_fewer_routes_than_asked_for(alternatives: Any) -> None:
    """Those found are shown and kept, and the exit code is that of no solution."""
    result = alternatives("--alternatives", 5)
    assert result.exit_code == 1
    assert "there are 3 routes" in result.stderr
    assert [line.split()[0] for line in result.stdout.splitlines() if "results/quick" in line][:3] == ["1", "2", "3"]
    assert open_results("results/quick-3").route.objective == 103.0
    assert not Path("results/quick-4/route.npz").exists()
    assert not Path("results/quick-5").exists()


def test_no_route_at_all(alternatives: Any, stages: FakeStages) -> None:
    """Then there is no table."""
    stages.routes = 0
    result = alternatives("--alternatives", 2, "--no-why-not")
    assert result.exit_code == 1
    assert result.stdout == ""


def test_a_folder_of_something_else_is_left_alone(alternatives: Any) -> None:
    """Neither another run nor files of the same names are replaced where nobody named the folder."""
    assert alternatives("--out", "a-2").exit_code == 0
    before = sorted((path, path.stat().st_mtime_ns) for path in Path("a-2").rglob("*"))
    result = alternatives("--out", "a", "--alternatives", 2)
    assert result.exit_code == 2
    assert "a-2 already holds another run" in result.stderr
    assert sorted((path, path.stat().st_mtime_ns) for path in Path("a-2").rglob("*")) == before
    assert not Path("a").exists()
    Path("b-2").mkdir()
    Path("b-2/route.npz").write_text("mine")
    result = alternatives("--out", "b", "--alternatives", 2)
    assert result.exit_code == 2
    assert Path("b-2/route.npz").read_text() == "mine"


def test_again_is_nothing_new(alternatives: Any) -> None:
    """The folders of a run before are its own."""
    first = alternatives("--alternatives", 2)
    again = alternatives("--alternatives", 2)
    assert again.exit_code == 0
    assert again.stdout == first.stdout


def test_routes_that_are_not_proven_optimal(alternatives: Any, stages: FakeStages) -> None:
    """All are shown and kept, and the exit code says that there is something to know."""
    stages.route_status = Status.UNPROVEN
    result = alternatives("--alternatives", 2)
    assert result.exit_code == 1
    assert "not proven optimal" in result.stderr
    assert [line.split()[0] for line in result.stdout.splitlines() if "results/quick" in line][:2] == ["1", "2"]
