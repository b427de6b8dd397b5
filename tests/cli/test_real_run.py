"""The real stages on the coarse grid, from the YAML file to the controller's table."""

import json
from pathlib import Path

import pytest
from typer.testing import CliRunner

from pipeline.cli import app
from pipeline.config import Config
from pipeline.config.file import dump_config, load_config
from pipeline.stage import STAGES
from tests.cli.calls import edit


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory, quick_config: Config) -> Path:
    """Run the coarse configuration once, with the real stages and few pieces of jerk."""
    folder = tmp_path_factory.mktemp("quick")
    file = tmp_path_factory.mktemp("configuration") / "quick.yaml"
    retime = quick_config.retime.model_copy(update={"jerk_pieces": 100})
    file.write_text(dump_config(quick_config.model_copy(update={"retime": retime})))
    result = CliRunner().invoke(app, ["run", str(file), "--out", str(folder)])
    assert result.exit_code == 0, result.output
    return folder


@pytest.mark.slow
class TestRealStages:
    """The real stages on the coarse grid, from the YAML file to the controller's table."""

    def test_summary(self, folder: Path) -> None:
        """The figures are those of a real reconfiguration within all limits."""
        told = json.loads((folder / "summary.json").read_text())
        assert told["regions"]["count"] > 20_000
        route, path, trajectory = told["route"], told["path"], told["trajectory"]
        assert (route["status"], route["gap"], route["mode_changes"]) == ("optimal", 0.0, 3)
        assert route["steps"] <= 25
        assert path["status"] == "converged"
        assert path["det_sign_constant"] is True
        assert path["kappa_max"] <= path["coarse_kappa_max"]
        assert path["kappa_integral"] < 0.87 * path["coarse_kappa_integral"]
        assert path["closure_residual_m"] < 1e-9
        assert path["max_tilt_deg"] <= 30.0
        assert path["min_link_distance_m"] >= 0.03
        usage = trajectory["usage"]
        assert trajectory["jerk"] == "limited"
        assert max(max(usage[name]) for name in ("velocity", "acceleration", "jerk", "force", "link_force")) <= 1.001
        assert 0.0 < trajectory["gap"] < 0.005
        assert trajectory["duration_bound_s"] < trajectory["duration_without_jerk_s"] < trajectory["duration_s"]

    def test_nothing_runs_twice(self, folder: Path) -> None:
        """The second run runs no stage and changes no file."""
        before = {path: path.read_bytes() for path in folder.rglob("*") if path.is_file() and path.name != ".lock"}
        result = CliRunner().invoke(app, ["run", str(folder / "config.yaml"), "--out", str(folder)])
        assert result.exit_code == 0
        assert all(f"{stage}: unchanged" in result.stderr for stage in STAGES)
        assert {path: path.read_bytes() for path in before} == before

    def test_loaded_results_are_those_made(self, folder: Path) -> None:
        """Stages three and the figures come out the same, byte for byte, from loaded results."""
        before = {path.name: path.read_bytes() for path in folder.iterdir() if path.suffix in (".csv", ".npz")}
        result = CliRunner().invoke(app, ["run", str(folder / "config.yaml"), "--out", str(folder), "--from", "retime"])
        assert result.exit_code == 0
        assert {path.name: path.read_bytes() for path in folder.iterdir() if path.suffix in (".csv", ".npz")} == before
        assert not (folder / "superseded").exists()

    def test_compare_agrees_with_summary(self, folder: Path) -> None:
        """Measured again from the files, the paths have the same figures."""
        rows = json.loads(CliRunner().invoke(app, ["compare", str(folder), "--json"]).stdout)
        path = json.loads((folder / "summary.json").read_text())["path"]
        assert {row["figure"]: row["refined"] for row in rows}["kappa integral"] == path["kappa_integral"]

    def test_no_route(self, tmp_path: Path, quick_config: Config) -> None:
        """With too little tilt there is a proof that no route exists, and exit code 1."""
        (tmp_path / "flat.yaml").write_text(dump_config(quick_config))
        edit(tmp_path / "flat.yaml", task__tilt_max_deg=5.0)
        result = CliRunner().invoke(app, ["run", str(tmp_path / "flat.yaml"), "--out", str(tmp_path / "out")])
        assert result.exit_code == 1
        assert "no route exists" in result.stderr
        told = json.loads((tmp_path / "out" / "summary.json").read_text())
        assert told["route"]["status"] == "infeasible"
        assert told["trajectory"]["status"] == "skipped"
        assert load_config(tmp_path / "out" / "config.yaml").task.tilt_max_deg == 5.0
