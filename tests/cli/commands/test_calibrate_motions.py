"""The command that calibrates, from motions: with the run that was driven, and a clock offset that is fitted."""

import json
from pathlib import Path

import pytest

from pipeline.config import Config
from pipeline.config.file import dump_config
from pipeline.run import RunOptions, run_pipeline
from pipeline.stage import Stage
from tests.cli.calls import invoke
from tests.run.fake_stages import FakeStages

REFLECTORS = ("--reflector-1", 0, 0.1, 0.05, "--reflector-2", 0, 0.4, 0.05)


@pytest.fixture
def run(tmp_path: Path, fast_config: Config, stages: FakeStages) -> Path:
    """Plan a short motion, and write its configuration beside it."""
    Path("cell.yaml").write_text(dump_config(fast_config))
    run_pipeline(fast_config, tmp_path / "run", RunOptions(last=Stage.RETIME), specs=stages.specs)
    return tmp_path / "run"


def test_static_poses_and_a_motion_make_one_calibration(run: Path) -> None:
    """The clock offset is told with its deviation, in words and in JSON."""
    assert invoke("simulate-poses", "cell.yaml", *REFLECTORS, "--output", "poses.csv").exit_code == 0
    moving = ("--run", run, "--clock", 0.0321, "--speed", 0.25)
    made = invoke("simulate-poses", "cell.yaml", *REFLECTORS, *moving, "--output", "motion.csv")
    assert made.exit_code == 0, made.output
    assert json.loads(Path("motion.json").read_text())["clock_s"] == 0.0321
    files = ("poses.csv", "motion.csv")
    result = invoke(
        "calibrate", "cell.yaml", *files, *REFLECTORS, "--run", run, "--speed", 0.25, "--output", "real.yaml"
    )
    assert result.exit_code == 0, result.output
    assert "motion 1: the clock of the tracker is late by +3" in result.stdout
    assert "elsewhere" in result.stdout
    (clock,) = json.loads(Path("real.json").read_text())["clocks"]
    assert abs(clock["late_s"] - 0.0321) < 4.0 * clock["std_s"] < 0.02


def test_options_of_motions_go_with_motions(run: Path) -> None:
    """What would be ignored is refused."""
    assert invoke("simulate-poses", "cell.yaml", *REFLECTORS, "--output", "poses.csv").exit_code == 0
    for options, said in (
        (("calibrate", "cell.yaml", "poses.csv", *REFLECTORS, "--run", run), "--run goes with files of motions"),
        (("calibrate", "cell.yaml", "poses.csv", *REFLECTORS, "--back"), "go with --run RUN"),
        (("simulate-poses", "cell.yaml", *REFLECTORS, "--clock", 0.1), "--clock goes with --run RUN"),
    ):
        refused = invoke(*options)
        assert refused.exit_code == 2
        assert said in refused.stderr


def test_a_motion_needs_its_run_and_its_times(run: Path) -> None:
    """Without a run, and with times of another unit or out of order, it is refused with what to do."""
    header = "t_s,x1_m,y1_m,z1_m,x2_m,y2_m,z2_m\n"
    Path("motion.csv").write_text(header + "".join(f"0.{k}0,1,{k},0,2,0,{k}\n" for k in range(5)))
    refused = invoke("calibrate", "cell.yaml", "motion.csv", *REFLECTORS)
    assert refused.exit_code == 2
    assert "has times t_s instead of encoders" in refused.stderr
    assert "--run RUN" in refused.stderr
    Path("motion.csv").write_text(header + "".join(f"{1000 * k},1,{k},0,2,0,{k}\n" for k in range(5)))
    refused = invoke("calibrate", "cell.yaml", "motion.csv", *REFLECTORS, "--run", run)
    assert refused.exit_code == 2
    assert "they look like milliseconds" in refused.stderr
    Path("motion.csv").write_text(header + "".join(f"0.{9 - k},1,{k},0,2,0,{k}\n" for k in range(5)))
    refused = invoke("calibrate", "cell.yaml", "motion.csv", *REFLECTORS, "--run", run)
    assert refused.exit_code == 2
    assert "motion.csv, line 3: times in t_s must increase" in refused.stderr
