"""The commands about measurements, on a run of fake stages."""

import json
from pathlib import Path
from typing import Any

import pytest

from tests.cli.calls import invoke as call
from tests.run.fake_stages import FakeStages


@pytest.fixture(autouse=True)
def _run(config_file: Path, stages: FakeStages) -> None:
    """Run fake stages into the folder `out` of an empty folder."""
    assert call("run", config_file, "--out", "out", specs=stages.specs).exit_code == 0


def errors(*arguments: object) -> dict[str, dict[str, Any]]:
    """Compare a measurement and give the rows by quantity."""
    result = call("measured", "out", *arguments, "--json")
    assert result.exit_code == 0, result.output
    return {row["quantity"]: row for row in json.loads(result.stdout)}


def test_there_and_back() -> None:
    """What is simulated without noise and errors is measured as commanded, to the decimals of the file."""
    assert call("simulate-measurement", "out", "--geometry", 0, "--noise", 0, "--output", "seen.csv").exit_code == 0
    rows = errors("seen.csv", "--noise", 0)
    assert max(abs(row["largest"]) for row in rows.values()) < 1e-9
    assert [row["unit"] for row in rows.values()] == ["m", "m", "m", "rad", "rad"]


@pytest.mark.parametrize("options", [("--period", 0.007), ("--speed", 0.3), ("--speed", 0.37, "--period", 0.003)])
def test_there_and_back_at_another_pace(options: tuple[object, ...]) -> None:
    """The same holds for what was exported slower, or at a period that does not divide the duration."""
    call("simulate-measurement", "out", "--geometry", 0, "--noise", 0, "--output", "seen.csv", *options)
    rows = errors("seen.csv", "--noise", 0, *options)
    assert max(abs(row["largest"]) for row in rows.values()) < 1e-9
    result = call("measured", "out", "seen.csv")
    assert result.exit_code == 2
    assert "give --speed or --period" in result.stderr


@pytest.mark.parametrize("separator", [";", "\t"])
def test_other_separators(separator: str) -> None:
    """Semicolons and tabs are read as commas are."""
    call("simulate-measurement", "out", "--output", "seen.csv")
    Path("other.csv").write_text(Path("seen.csv").read_text().replace(",", separator))
    assert errors("other.csv") == errors("seen.csv")


def test_noise_is_told_by_the_error_bars() -> None:
    """With noise alone, errors are about as large as their bars."""
    call("simulate-measurement", "out", "--geometry", 0, "--period", 0.005, "--output", "seen.csv")
    assert all(0.8 < row["standardised_rms"] < 1.2 for row in errors("seen.csv").values())


def test_a_wrong_machine_shows() -> None:
    """Errors of the geometry are far outside the noise of a good tracker."""
    call("simulate-measurement", "out", "--geometry", 0.001, "--noise", 1e-6, "--output", "seen.csv")
    assert max(row["standardised_rms"] for row in errors("seen.csv", "--noise", 1e-6).values()) > 10.0


def test_a_file_says_how_it_was_made() -> None:
    """Beside a simulated measurement there is a file that says that it is one, with seed, errors and reflectors."""
    call("simulate-measurement", "out", "--seed", 4, "--output", "seen.csv")
    facts = json.loads(Path("seen.json").read_text())
    assert facts["simulated"] is True
    assert facts["speed"] == 1.0
    assert facts["period_s"] > 0.0
    assert facts["setting"] == {"geometry_std_m": 2e-4, "seed": 4}
    assert facts["reflectors"]["noise_m"] == 5e-5


def test_stdout_is_the_file() -> None:
    """Without --output the table goes to stdout, the same for the same seed."""
    call("simulate-measurement", "out", "--seed", 4, "--output", "seen.csv")
    assert call("simulate-measurement", "out", "--seed", 4).stdout == Path("seen.csv").read_text()


def test_a_trajectory_is_a_measurement_too() -> None:
    """The commanded trajectory as measured one has no errors and no error bars."""
    rows = errors("out/trajectory.csv")
    assert max(abs(row["largest"]) for row in rows.values()) < 1e-9
    assert {row["error_bar"] for row in rows.values()} == {None}


def test_table_and_picture() -> None:
    """The table names every quantity with its unit; the picture is written where it was asked for."""
    call("simulate-measurement", "out", "--output", "seen.csv")
    result = call("measured", "out", "seen.csv", "--picture", "seen.png")
    assert result.exit_code == 0
    for text in ("rms error", "rx", "rz", "mm", "deg"):
        assert text in result.stdout
    assert Path("seen.png").read_bytes().startswith(b"\x89PNG")


@pytest.mark.parametrize(
    ("arguments", "expected"),
    [
        (("measured", "out", "bad.csv"), "line 2"),
        (("measured", "out", "seen.csv", "--reflector-2", 0, 0.1, 0.05), "in one place"),
        (("measured", "out", "seen.csv", "--picture", "seen.gif"), ".png"),
        (("measured", "out", "none.csv"), "none.csv"),
        (("measured", "nowhere", "seen.csv"), "does not exist"),
        (("simulate-measurement", "out", "--output", "out/seen.csv"), "not overwritten"),
        (("simulate-measurement", "out", "--period", 10), "period"),
        (("simulate-measurement", "out", "--output", "facts.json"), "another ending"),
        (("simulate-measurement", "out", "--output", "out/../folder"), "folder: Is a directory"),
        (("measured", "out", "folder"), "folder: Is a directory"),
        (("measured", "out", "seen.csv", "--speed", 2), "speed"),
    ],
)
def test_bad_usage(arguments: tuple[object, ...], expected: str) -> None:
    """What cannot be used is refused with the reason, and nothing is written."""
    call("simulate-measurement", "out", "--output", "seen.csv")
    Path("bad.csv").write_text("t_s,x_m\n1\n")
    Path("folder").mkdir()
    before = sorted(Path().rglob("*"))
    result = call(*arguments)
    assert result.exit_code == 2
    assert expected in result.stderr
    assert sorted(Path().rglob("*")) == before


@pytest.mark.parametrize("command", ["measured", "simulate-measurement"])
def test_help_has_examples(command: str) -> None:
    """The help of both commands has an example that names it."""
    assert f"gantry-tau {command} results/agder" in call(command, "--help").stdout
