"""The command that corrects a run for a calibrated machine: a run folder of its own, proven for that machine."""

import json
from pathlib import Path

import numpy as np
import pytest
import yaml

from pipeline.config import Config
from pipeline.config.file import dump_config, load_config, parse_config
from pipeline.export.csv import read_csv
from pipeline.export.trajectory_columns import POSITIONS
from pipeline.machine.actuator_space.controller_units import controller_units
from pipeline.run import RunOptions, open_results, run_pipeline
from pipeline.stage import Stage
from tests.cli.calls import edit, invoke
from tests.run.fake_stages import FakeStages

ENDS = {
    "start": {"mode": "LLL", "x_m": 1.02, "y_m": 0.3, "z_m": 0.9, "rx_deg": 0.0, "rz_deg": 0.0},
    "goal": {"mode": "LLL", "x_m": 1.05, "y_m": 0.33, "z_m": 0.88, "rx_deg": 2.8647889757, "rz_deg": -1.1459155903},
}


def plan(folder: Path, config: Config, stages: FakeStages, **task: object) -> Path:
    """Plan a short straight way with few pieces of jerk; the path is made up, but real."""
    data = config.model_dump(mode="json")
    data["task"] |= {**ENDS, **task}
    data["route"]["avoid_margin"] = 0.0
    data["retime"] |= {"jerk_pieces": 40, "grid_points": 200}
    run_pipeline(parse_config(data), folder, RunOptions(last=Stage.REFINE), specs=stages.specs)
    return folder


@pytest.fixture
def run(tmp_path: Path, fast_config: Config, stages: FakeStages) -> Path:
    """Plan a run."""
    return plan(tmp_path / "planned", fast_config, stages)


@pytest.fixture
def real(tmp_path: Path, run: Path) -> Path:
    """Give a machine that is a little off, with zeros and scales of its encoders."""
    file = tmp_path / "real.yaml"
    file.write_text(dump_config(load_config(run / "config.yaml")))
    data = yaml.safe_load(file.read_text())["machine"]
    links, rails = data["links"], data["rails"]
    rails[1]["z_m"] += 2e-4
    links["l1"]["length_m"] += 3e-4
    links["l2b"]["platform_point_m"][1] -= 2e-4
    actuators = {"c1": {"zero_m": 1e-3, "scale": 1.0001}, "l2b": {"zero_m": -5e-4, "scale": 1.0}}
    return edit(file, machine={**data, "actuators": {**data["actuators"], **actuators}})


def test_a_run_is_corrected_and_proven(run: Path, real: Path, tmp_path: Path, stages: FakeStages) -> None:
    """The corrected run has the planned poses, on the other machine, with a certificate of that machine that holds."""
    result = invoke("correct", run, "--machine", real, "--json")
    assert result.exit_code == 0, result.output
    said = json.loads(result.stdout)
    out = tmp_path / "planned-corrected"
    facts = said["corrected"]["correction"]
    assert said["corrected"]["verdict"] == "certified"
    assert said["verdict"] is None
    assert facts["before"]["rms_m"] > 5e-4
    assert facts["after"]["largest_m"] < 1e-6
    assert json.loads((out / "summary.json").read_text())["path"]["correction"] == facts

    results, planned = open_results(out, Stage.REFINE, Stage.CERTIFY, Stage.RETIME), open_results(run, Stage.REFINE)
    s = np.linspace(0.0, 1.0, 101)
    poses, goal = results.refinement.path.pose(s), planned.refinement.path.pose(s)
    assert np.delete(poses - goal, 4, axis=1) == pytest.approx(0.0, abs=1e-6)
    table = read_csv((out / "trajectory.csv").read_text())
    q = np.stack([table[name] for name in POSITIONS], axis=1)
    units = controller_units(results.config.machine)
    assert units.to_geometry(q[0]) == pytest.approx(results.refinement.path.q(0.0), abs=1e-9)
    assert units.zeros_m == pytest.approx([1e-3, 0.0, 0.0, -5e-4, 0.0])
    rows = read_csv((out / "correction.csv").read_text())
    change = np.array([rows[f"d{name}_m"][-1] for name in ("c1", "c2", "c3", "l2b", "l3b")])
    assert change == pytest.approx(results.refinement.path.q(1.0) - planned.refinement.path.q(1.0), abs=1e-9)

    assert invoke("certify", "--check", out).exit_code == 0
    assert invoke("export", out, "--output", tmp_path / "new.csv").exit_code == 0
    again = invoke("correct", run, "--machine", real)
    assert again.exit_code == 0
    assert "refine: unchanged" in again.stderr
    assert "Proven for the calibrated machine" in again.stdout
    assert f"--plan-again {run}-again" in again.stdout
    other = tmp_path / "again"
    both = invoke("correct", run, "--machine", real, "--plan-again", other, "--json", specs=stages.specs)
    assert both.exit_code == 0, both.output
    judged = json.loads(both.stdout)
    assert judged["verdict"]["better"] == "plan again"
    assert judged["planned_again"]["verdict"] == "certified"
    assert "planned again it leaves 0.000 mm" in judged["verdict"]["reasons"][0]
    assert open_results(other, Stage.RETIME).config == results.config
    refused = invoke("run", out / "config.yaml", "--out", out)
    assert refused.exit_code == 2
    assert "was corrected for another machine" in refused.stderr


def test_limits_that_break_are_told_with_planning_again(
    real: Path, tmp_path: Path, fast_config: Config, stages: FakeStages
) -> None:
    """A corrected path that enters a box to avoid ends with exit code 1, and without a trajectory."""
    avoid = [{"x_m": [1.03, 1.04], "y_m": [0.31, 0.32]}]
    run = plan(tmp_path / "through", fast_config, stages, avoid=avoid)
    result = invoke("correct", run, "--machine", real, "--out", tmp_path / "out")
    assert result.exit_code == 1, result.output
    assert "the corrected path breaks limits of the calibrated machine: task.avoid[0] is entered" in result.stderr
    assert "--plan-again DIR" in result.stderr
    assert not (tmp_path / "out" / "trajectory.csv").exists()


def test_what_cannot_be_corrected_is_refused(run: Path, real: Path) -> None:
    """The same machine, the run itself as output, and what is not a run are refused before anything is written."""
    same = invoke("correct", run, "--machine", run / "config.yaml")
    assert same.exit_code == 2
    assert "has the machine that was planned for" in same.stderr
    itself = invoke("correct", run, "--machine", real, "--out", run)
    assert itself.exit_code == 2
    assert "--out and RUN are the same file" in itself.stderr
    assert invoke("correct", real.parent, "--machine", real).exit_code == 2
    assert not Path(f"{run}-corrected").exists()
