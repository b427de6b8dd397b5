"""The commands `simulate` and `tune`, on a run of fake stages."""

import json
from pathlib import Path
from typing import Any

import pytest
import yaml

from tests.cli.calls import invoke as call
from tests.run.fake_stages import FakeStages, proven


@pytest.fixture(autouse=True)
def _run(config_file: Path, stages: FakeStages) -> None:
    """Run fake stages into the folder `out` of an empty folder."""
    assert call("run", config_file, "--out", "out", specs=stages.specs).exit_code == 0


def simulated(*arguments: object, exit_code: int = 0) -> dict[str, Any]:
    """Simulate and give the data."""
    result = call("simulate", "out", *arguments, "--json")
    assert result.exit_code == exit_code, result.output
    data: dict[str, Any] = json.loads(result.stdout)
    return data


def drives_file(name: str, **keys: object) -> Path:
    """Write a file with drives that share some keys."""
    path = Path(name)
    path.write_text(yaml.safe_dump({"drives": {"carts": keys, "telescopes": keys}}))
    return path


@pytest.mark.parametrize("options", [("--back",), ("--speed", 0.7, "--period", 0.0007)])
def test_what_it_writes_is_measured_with_the_same_errors(options: tuple[object, ...]) -> None:
    """The file is a measurement as it is; beside it says that it is simulated, and how."""
    data = simulated("--output", "twin.csv", "--mass-error", 5, *options)
    measured = call("measured", "out", "twin.csv", *options, "--json")
    assert measured.exit_code == 0, measured.output
    for seen, expected in zip(json.loads(measured.stdout), data["errors"], strict=True):
        assert seen["quantity"] == expected["quantity"]
        assert seen["largest"] == pytest.approx(expected["largest"], abs=1e-8)
    facts = json.loads(Path("twin.json").read_text())
    assert facts["simulated"] is True
    assert facts["setting"]["mass_error"] == 0.05
    assert facts["back"] is ("--back" in options)
    assert data["verdict"]["ending"] == "arrived"
    # By default controllers run at a whole part of the run's period of 10 ms.
    assert data["period_s"] == pytest.approx(0.0007 if "--period" in options else 0.001)


def test_it_shows_tables_and_pictures() -> None:
    """Errors, drives, links, modes and the verdict; three pictures."""
    result = call("simulate", "out", "--geometry", 0.0002, "--seed", 2, "--picture", "twin.png")
    assert result.exit_code == 0
    for shown in ("TCP", "following", "saturated", "links", "planned", "det H keeps its sign", "arrived after"):
        assert shown in result.stdout + result.stderr
    assert [Path(name).read_bytes()[:4] for name in ("twin.png", "twin_following.png", "twin_forces.png")] == [
        b"\x89PNG"
    ] * 3


def test_it_says_whether_the_motion_stays_within_what_is_proven(config_file: Path, stages: FakeStages) -> None:
    """With a certificate that has a tube; without, how to get one."""
    result = call("simulate", "out")
    assert "no tube about the path is proven: gantry-tau certify out/config.yaml --out out --following" in result.stdout
    assert call("run", config_file, "--out", "out", "--force", specs=proven(stages, 2e-2)).exit_code == 0
    result = call("simulate", "out")
    assert "contour errors against the proven tube" in result.stdout
    assert "within the proven tube of 20 mm, " in result.stdout
    assert "these drives trip too late" not in result.stdout


def test_drives_of_another_file_are_used() -> None:
    """A drive that trips ends the motion with exit code 1, with what happened, when, and what to change."""
    keys = {"position_gain_per_s": 0.1, "feed_forward": {"velocity": 0.0}, "following_error_trip_m": 0.001}
    result = call("simulate", "out", "--drives", drives_file("weak.yaml", **keys), "--output", "twin.csv")
    assert result.exit_code == 1
    assert "trips: its following error is" in result.stderr
    assert "What to change: Take gains that are stable" in result.stderr
    assert Path("twin.csv").exists()
    heavy = call("simulate", "out", "--load", 400)
    assert heavy.exit_code == 1
    assert "gave all the force they have: carry less (--load)" in heavy.stderr
    assert "while standing at the start" in heavy.stderr
    result = call("simulate", "out", "--drives", drives_file("wrong.yaml", kp=1))
    assert result.exit_code == 2
    assert "wrong.yaml" in result.stderr
    assert "drives.carts.kp" in result.stderr
    Path("none.yaml").write_text("machine: {}")
    result = call("simulate", "out", "--drives", "none.yaml")
    assert result.exit_code == 2
    assert "drives: is missing" in result.stderr


def test_results_and_measurements_are_not_overwritten() -> None:
    """Neither those of the run, nor a file beside that says something else."""
    for option in ("--output", "--picture"):
        assert call("simulate", "out", option, "out/twin.png").exit_code == 2
    Path("seen.json").write_text("{}")
    result = call("simulate", "out", "--output", "seen.csv")
    assert result.exit_code == 2
    assert "seen.json" in result.stderr


def test_tuned_gains_can_be_simulated() -> None:
    """What is printed is a section of drives that keeps the other keys; the table is on stderr."""
    given = drives_file("given.yaml", moving_mass_kg=8.0)
    result = call("tune", "out", "--damping", 0.4, "--drives", given)
    assert result.exit_code == 0, result.output
    assert "as configured" in result.stderr
    found = yaml.safe_load(result.stdout)["drives"]
    for kind in ("carts", "telescopes"):
        assert found[kind].keys() == {
            "moving_mass_kg",
            "position_gain_per_s",
            "velocity_gain_nspm",
            "integral_time_s",
        }
    Path("tuned.yaml").write_text(result.stdout)
    assert simulated("--drives", "tuned.yaml")["drives"] is not None


def test_tune_says_when_there_is_nothing() -> None:
    """With the best that there is, and exit code 1; nothing is printed that could be pasted."""
    late = drives_file("late.yaml", force_lag_s=0.2)
    result = call("tune", "out", "--damping", 0.9, "--drives", late)
    assert result.exit_code == 1
    assert "no gains have a damping of 0.9" in result.stderr
    assert not result.stdout.strip()
