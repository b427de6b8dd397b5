"""The commands that simulate static poses, and calibrate from them."""

import json
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from typer.testing import Result

from pipeline.cli.calibration.pictures import NAMES
from pipeline.config.file import load_config
from tests.cli.calls import invoke as call
from tests.cli.calls import subprocess_env
from tests.conftest import CONFIGS

REFLECTORS = ("--reflector-1", 0, 0.1, 0.05, "--reflector-2", 0, 0.4, 0.05)


@pytest.fixture(autouse=True)
def _folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Work in a folder with a configuration."""
    monkeypatch.chdir(tmp_path)
    shutil.copy(CONFIGS / "quick.yaml", "cell.yaml")


def simulate(*options: object) -> None:
    """Simulate poses into poses.csv."""
    result = call("simulate-poses", "cell.yaml", *REFLECTORS, "--output", "poses.csv", *options)
    assert result.exit_code == 0, result.output


def calibrate(*options: object) -> Result:
    """Calibrate from poses.csv."""
    return call("calibrate", "cell.yaml", "poses.csv", *REFLECTORS, *options)


def test_from_poses_to_a_calibrated_configuration() -> None:
    """The new configuration is that of the simulated machine within its deviations, with all that JSON says of it."""
    simulate("--poses", 60)
    result = calibrate("--hold-out", 0.25, "--output", "real.yaml")
    assert result.exit_code == 0, result.output
    assert "from the data" in result.stdout
    assert "held out" in result.stdout
    said, truth = json.loads(Path("real.json").read_text()), json.loads(Path("poses.json").read_text())["truth"]
    rows = said["parameters"]
    assert len(rows) == len(said["covariance"]) == 74
    off = [
        (row["configured"] + row["change"] - truth[row["name"]]) / row["std"]
        for row in rows
        if row["std"] > 0.0 and not row["name"].startswith("tracker")
    ]
    assert np.abs(off).max() < 4.5
    new = load_config("real.yaml").machine
    by_name = {row["name"]: row["configured"] + row["change"] for row in rows}
    assert new.links.l2a.length_m == pytest.approx(by_name["length 2a"], abs=1e-9)
    assert new.actuators.l3b.zero_m == pytest.approx(by_name["zero l3b"], abs=1e-9)
    assert new.rails[1].z_m == pytest.approx(by_name["rail 2 z"], abs=1e-9)
    assert said["errors"]["held_out"]["after_m"] < 0.3 * said["errors"]["held_out"]["before_m"]
    assert said["files"][0]["rows"] == 60
    again = calibrate("--hold-out", 0.25, "--output", "real.yaml", "--json")
    assert json.loads(again.stdout) == said


def test_what_is_refused_writes_nothing() -> None:
    """Exit code 1, the reason and what to change, and no file; outliers are left out if asked."""
    simulate("--outliers", 0.05)
    result = calibrate("--output", "real.yaml")
    assert result.exit_code == 1
    assert "points are outliers (poses.csv, line" in result.stderr
    assert "What to change: --robust" in result.stderr
    assert not Path("real.yaml").exists()
    assert not Path("real.json").exists()
    robust = calibrate("--robust", "--output", "real.yaml")
    assert robust.exit_code == 0
    rejected = json.loads(Path("real.json").read_text())["rejected"]
    assert len(rejected) == sum(map(sum, json.loads(Path("poses.json").read_text())["outliers"])) > 0


def test_rails_are_told_and_written() -> None:
    """Slopes are found and written with directions in --fit; without, they are the reason."""
    simulate("--rails", 0.0004)
    assert "Rails that are not parallel do" in calibrate().stderr
    every = (
        "--fit",
        "platform,offsets,rails,lengths,zeros,scales,directions,reflectors",
        "--prior",
        "directions=0.001",
    )
    result = calibrate(*every)
    assert result.exit_code == 0, result.stderr
    assert "direction of rail 3 z" in result.stdout
    written = calibrate(*every, "--output", "real.yaml")
    assert written.exit_code == 0, written.stderr
    truth = json.loads(Path("poses.json").read_text())["truth"]
    true = np.array([truth[name] for name in truth if name.startswith("direction")]).reshape(3, 2)
    slopes = np.array([rail.slopes for rail in load_config(Path("real.yaml")).machine.rails])
    # The machine's frame may turn with all rails: only their directions against one another are seen.
    assert slopes - slopes.mean(axis=0) == pytest.approx(true - true.mean(axis=0), abs=5e-5)


def test_a_file_beside_that_says_something_else_is_kept() -> None:
    """As beside every output."""
    simulate()
    Path("real.json").write_text("{}")
    result = calibrate("--output", "real.yaml")
    assert (result.exit_code, "real.json" in result.stderr) == (2, True)
    assert Path("real.json").read_text() == "{}"
    assert not Path("real.yaml").exists()


def test_poses_go_to_stdout_without_a_file() -> None:
    """The same table, and no file that says how it was made."""
    simulate("--poses", 5)
    result = call("simulate-poses", "cell.yaml", *REFLECTORS, "--poses", 5)
    assert result.stdout == Path("poses.csv").read_text()
    assert len(result.stdout.splitlines()) == 6


def test_poses_are_proposed_before_and_after_measuring() -> None:
    """Without a file moderate ones, with one those that add most; tables of them are read once they are filled in."""
    result = call("calibrate", "cell.yaml", *REFLECTORS, "--next", 4, "--next-output", "first.csv", "--json")
    assert result.exit_code == 0, result.output
    proposed = json.loads(result.stdout)["next"]
    assert max(proposed["kappa"]) <= 25.0
    table = Path("first.csv").read_text().splitlines()
    assert table[0].startswith("q1_m,q2_m,q3_m,q4_m,q5_m,x1_m")
    assert len(table) == 5
    unfilled = call("calibrate", "cell.yaml", "first.csv", *REFLECTORS)
    assert (unfilled.exit_code, "0 poses with a reflector" in unfilled.stderr) == (2, True)
    simulate()
    after = json.loads(calibrate("--next", 2, "--json").stdout)
    assert len(after["next"]["q_m"]) == 2
    assert after["next"]["error_m"][2] < after["next"]["error_m"][0] < 5e-4
    assert "poses to measure next" in calibrate("--next", 1).stdout


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ((), "FILE is missing"),
        (("--next", 3, "--output", "real.yaml"), "FILE is missing"),
        (("--next-output", "then.csv"), "--next N"),
        (("--next", 3, "--next-output", "cell.yaml"), "the same file"),
    ],
)
def test_nothing_to_calibrate_from(options: tuple[object, ...], message: str) -> None:
    """Poses are measured or asked for, and go to a file of their own."""
    result = call("calibrate", "cell.yaml", *REFLECTORS, *options)
    assert (result.exit_code, message in result.stderr) == (2, True), result.stderr


def test_a_table_to_be_filled_in_is_simulated() -> None:
    """By the same machine as without it, but not with the same noise; what a table is for is what it gives."""
    simulate("--poses", 20)
    table = call("calibrate", "cell.yaml", *REFLECTORS, "--next", 12, "--next-output", "first.csv")
    assert "gantry-tau tour" in table.stderr
    at = ("simulate-poses", "cell.yaml", *REFLECTORS, "--poses", 20, "--at", "first.csv")
    assert call(*at, "--output", "filled.csv").exit_code == 0
    truths = [json.loads(Path(name).read_text())["truth"] for name in ("poses.json", "filled.json")]
    assert truths[0] == truths[1]
    result = call("calibrate", "cell.yaml", "poses.csv", "filled.csv", *REFLECTORS)
    assert result.exit_code == 0, result.output
    assert len(Path("filled.csv").read_text().splitlines()) == 13
    assert call(*at, "--outliers", 0.1).exit_code == 2
    assert call(*at, "--output", "first.csv").exit_code == 2


def test_pictures_are_beside_their_name() -> None:
    """A file per figure, also where the calibration is refused; before anything is measured there is none."""
    simulate("--outliers", 0.05)
    result = calibrate("--picture", "cal.svg")
    assert result.exit_code == 1
    written = {file.name for file in Path().glob("cal-*.svg")}
    assert written == {f"cal-{name}.svg" for name in NAMES}
    assert "cal-*.svg: 5 figures" in result.stderr
    for options, message in (
        (("poses.csv", "--picture", "cal.txt"), "must end in"),
        (("--next", 3, "--picture", "cal.svg"), "give a FILE"),
    ):
        refused = call("calibrate", "cell.yaml", *options, *REFLECTORS)
        assert (refused.exit_code, message in refused.stderr) == (2, True), refused.stderr


def test_a_configuration_into_a_pipe_comes_alone() -> None:
    """What goes to stdout is the configuration; tables go to stderr, and there is no file beside."""
    simulate()
    process = subprocess.run(
        [sys.executable, "-m", "pipeline", "calibrate", "cell.yaml", "poses.csv", *map(str, REFLECTORS)]
        + ["--output", "/dev/stdout"],
        capture_output=True,
        text=True,
        check=True,
        env={**subprocess_env(), "PYTHONPATH": str(CONFIGS.parent)},
    )
    Path("piped.yaml").write_text(process.stdout)
    assert load_config("piped.yaml").machine.actuators.c1.zero_m != 0.0
    assert "from the data" in process.stderr
