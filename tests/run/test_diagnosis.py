"""What a run says of a route that does not exist."""

import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest
from markupsafe import escape
from typer.testing import CliRunner

from pipeline.artifacts import read_state
from pipeline.cli import app
from pipeline.config import Config
from pipeline.config.file import dump_config, load_config
from pipeline.errors import ConfigError, InfeasibleError, NoSolutionError
from pipeline.progress import Monitor
from pipeline.route import build_regions
from pipeline.run import Results, RunOptions, run_pipeline
from pipeline.run.diagnosis import Diagnosis, diagnose
from pipeline.run.failure import is_proven_infeasible
from pipeline.run.stage_specs import SPECS, Specs
from pipeline.stage import Stage
from tests.conftest import CONFIGS

KEY = "route.step_budget"


@pytest.fixture(scope="module")
def narrow(change) -> Config:
    """Take a small task with too few steps, on a grid whose ends are close to singular: few values to try."""
    config = load_config(CONFIGS / "tiny.yaml")
    tilts = {"route__grid__rx_step_deg": 10, "route__grid__rz_step_deg": 10, "task__tilt_max_deg": 10}
    forces = ("carts__force_n", "telescopes__force_n", "link_force_n")
    return change(config, **tilts, **{f"machine__limits__{key}": None for key in forces}, route__step_budget=5)


def test_proofs_alone_are_diagnosed() -> None:
    """Limits of time, too few alternatives and bad configurations have nothing to explain."""
    assert is_proven_infeasible(InfeasibleError("route", "none", "more"))
    assert is_proven_infeasible(InfeasibleError("route", "none", "more", {"status": "infeasible"}))
    assert not is_proven_infeasible(NoSolutionError("route", "late", "more", {"status": "time limit"}))
    assert not is_proven_infeasible(NoSolutionError("route", "none", "more"))
    assert not is_proven_infeasible(ConfigError([]))
    too_few = InfeasibleError("route", "only 2 routes", "more", {"status": "infeasible", "routes": 2})
    assert not is_proven_infeasible(too_few)


def test_the_route_alone_is_diagnosed() -> None:
    """No other stage can explain that there is no solution."""
    assert [spec.stage for spec in SPECS if spec.explain is not None] == [Stage.ROUTE]


def test_failed_run_says_why(tmp_path: Path, narrow: Config) -> None:
    """The message names what opens a route; the same is kept as numbers, with a picture."""
    with pytest.raises(NoSolutionError) as caught:
        run_pipeline(narrow, tmp_path / "out", RunOptions(last=Stage.ROUTE))
    note, shown, kept = caught.value.__notes__
    assert caught.value.advice == f"set {KEY} to 8 (tried: a route exists)"
    assert note.startswith("Why not:\n    Reach: of ")
    assert f"\n    - {KEY} 8 instead of 5: a route exists, sum of kappa " in note
    assert note.index(KEY) < note.index("task.tilt_max_deg")
    assert str(tmp_path / "out" / "failed" / "route.png") in shown
    assert str(tmp_path / "out" / "failed" / "route.json") in kept
    told = json.loads((tmp_path / "out" / "failed" / "route.json").read_text())["why_not"]
    assert json.loads((tmp_path / "out" / "failed" / "route.json").read_text())["advice"] == caught.value.advice
    assert set(told) == {"reach", "continuum", "remarks", "not_tried", "findings", "seconds"}
    (opening,) = (finding for finding in told["findings"] if finding["verdict"] == "a route exists")
    assert (opening["key"], opening["configured"], opening["value"], opening["refused"]) == (KEY, 5, 8, 7)
    assert opening["sentence"] in note
    assert f"Without the grid: {told['continuum']}" in note
    assert "proven for this grid" in told["continuum"]
    listed = json.loads((tmp_path / "out" / "summary.json").read_text())["route"]["why_not"]
    assert f"- {opening['sentence']}" in listed
    page = (tmp_path / "out" / "failed" / "route.html").read_text()
    assert f"<li>{escape(listed[-1].removeprefix('- '))}</li>" in page
    assert (tmp_path / "out" / "failed" / "route.png").read_bytes().startswith(b"\x89PNG")
    assert not (tmp_path / "out" / "superseded").exists()


def test_the_picture_goes_with_the_failure(tmp_path: Path, narrow: Config, change) -> None:
    """Once a route is found the picture moves aside like the rest of the failure."""
    with pytest.raises(NoSolutionError):
        run_pipeline(narrow, tmp_path / "out", RunOptions(last=Stage.ROUTE))
    run_pipeline(change(narrow, route__step_budget=8), tmp_path / "out", RunOptions(last=Stage.ROUTE))
    assert not (tmp_path / "out" / "failed").exists()
    assert (tmp_path / "out" / "superseded" / "0001" / "failed" / "route.png").exists()


def test_without_diagnosis(tmp_path: Path, narrow: Config) -> None:
    """It can be left out: the failure is kept as ever."""
    with pytest.raises(NoSolutionError) as caught:
        run_pipeline(narrow, tmp_path / "out", RunOptions(last=Stage.ROUTE, why_not=False))
    assert len(caught.value.__notes__) == 1
    assert "why_not" not in json.loads((tmp_path / "out" / "failed" / "route.json").read_text())
    assert not (tmp_path / "out" / "failed" / "route.png").exists()


def explained_by(explain: Callable[..., Diagnosis]) -> Specs:
    """Give the real stages, but with another diagnosis."""
    return tuple(replace(spec, explain=explain) if spec.stage is Stage.ROUTE else spec for spec in SPECS)


def test_interrupted_diagnosis(tmp_path: Path, narrow: Config) -> None:
    """Ctrl-C ends the diagnosis, not the message: the failure is reported and kept."""

    def interrupted(*_: object) -> Diagnosis:
        raise KeyboardInterrupt

    with pytest.raises(NoSolutionError) as caught:
        run_pipeline(narrow, tmp_path / "out", RunOptions(last=Stage.ROUTE), specs=explained_by(interrupted))
    assert caught.value.__notes__[0].startswith("Why not: interrupted")
    assert (tmp_path / "out" / "failed" / "route.json").exists()
    assert not (tmp_path / "out" / "failed" / "route.png").exists()


@pytest.mark.parametrize("trouble", [ValueError, MemoryError, SystemExit])
def test_failed_diagnosis(tmp_path: Path, narrow: Config, trouble: type) -> None:
    """Whatever else ends the diagnosis is reported; the failure of the route was recorded before."""

    def fails(*_: object) -> Diagnosis:
        raise trouble

    with pytest.raises(trouble):
        run_pipeline(narrow, tmp_path / "out", RunOptions(last=Stage.ROUTE), specs=explained_by(fails))
    kept = json.loads((tmp_path / "out" / "failed" / "route.json").read_text())
    assert "step_budget" in kept["advice"]
    assert read_state(tmp_path / "out").stages[Stage.ROUTE].status == "failed"


@pytest.mark.parametrize("command", ["run", "route"])
def test_option(tmp_path: Path, narrow: Config, command: str) -> None:
    """--no-why-not of `run` and `route` skips the diagnosis; without it the command line shows the findings."""
    path = tmp_path / "narrow.yaml"
    path.write_text(dump_config(narrow))
    short = CliRunner().invoke(app, [command, str(path), "--out", str(tmp_path / "a"), "--no-why-not"])
    assert (short.exit_code, "Why not" in short.stderr) == (1, False)
    assert "What to change" in short.stderr
    full = CliRunner().invoke(app, [command, str(path), "--out", str(tmp_path / "b")])
    assert full.exit_code == 1
    assert f"\n    - {KEY} 8 instead of 5: a route exists" in full.stderr


def test_progress_says_what_is_looked_at(tmp_path: Path, narrow: Config, machine) -> None:
    """Every message names the limit."""
    said: list[str] = []
    results = Results(narrow, machine, tmp_path)
    results.keep(Stage.REGIONS, build_regions(narrow, machine))
    diagnose(results, Monitor(lambda message, fraction=None: said.append(message)))
    assert all(message.startswith("why not: ") for message in said)
    for key in ("task.tilt_max_deg", "route.kappa_max", "machine.clearance.link_link_m", KEY):
        assert any(key in message for message in said)


def test_no_path_at_all_is_said(tmp_path: Path, change) -> None:
    """Without tilt "no route" is not a matter of the grid: the theorem is part of why not."""
    config = change(load_config(CONFIGS / "tiny.yaml"), task__tilt_max_deg=0)
    with pytest.raises(NoSolutionError) as caught:
        run_pipeline(config, tmp_path / "out", RunOptions(last=Stage.ROUTE))
    assert "Without the grid: no path exists" in caught.value.__notes__[0]
