"""The commands about measurements, on a run of fake stages."""

import json
from pathlib import Path
from typing import Any

import numpy as np
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


def test_there_and_back_on_the_way_back() -> None:
    """With --back both commands take the way back, at any pace; the other way is recognised."""
    options = ("--back", "--speed", 0.5)
    call("simulate-measurement", "out", "--geometry", 0, "--noise", 0, "--output", "seen.csv", *options)
    assert json.loads(Path("seen.json").read_text())["back"] is True
    assert max(abs(row["largest"]) for row in errors("seen.csv", "--noise", 0, *options).values()) < 1e-9
    for arguments in (("seen.csv", "--speed", 0.5), ("out/trajectory.csv", "--back")):
        result = call("measured", "out", *arguments)
        assert result.exit_code == 2
        assert "the other way" in result.stderr
    call("export", "out", "--back", "--output", "back.csv")
    assert max(abs(row["largest"]) for row in errors("back.csv", "--back").values()) < 1e-9


def test_what_was_skipped_is_said() -> None:
    """As Excel writes it, with a gap: the same errors of the other rows, and on stderr and in the JSON what is not."""
    call("simulate-measurement", "out", "--output", "seen.csv")
    header, *rows = Path("seen.csv").read_text().splitlines()
    gap = ",".join(["---"] * 7)
    lines = ["Tracker", header, "s,m,m,m,m,m,m", *rows[:3], gap, *rows[3:], ",,,,,,"]
    excel = "\r\n".join(lines).replace(".", "#").replace(",", ";").replace("#", ",")
    Path("excel.csv").write_bytes(b"\xff\xfe" + excel.encode("utf-16-le"))
    seen, read = errors("seen.csv"), errors("excel.csv")
    assert {row["rows"] for row in read.values()} == {len(rows)}
    assert [(one["reason"], one["lines"]) for one in read["x"].pop("skipped")] == [
        ("above the header", "1"),
        ("of units", "3"),
        (f"with a gap in {header.replace(',', ', ')}", "7"),
        ("without values", str(len(lines))),
    ]
    assert seen["x"].pop("skipped") == []
    assert read["x"] == seen["x"]
    result = call("measured", "out", "excel.csv", "--picture", "seen.png")
    assert f"excel.csv: {len(rows)} rows of t_s, x1_m" in result.stderr
    assert "UTF-16, semicolons, decimal commas" in result.stderr
    assert "skipped: 1 line of units (3)" in result.stderr


def test_noise_is_told_by_the_error_bars() -> None:
    """With noise alone, errors are about as large as their bars."""
    call("simulate-measurement", "out", "--geometry", 0, "--period", 0.005, "--output", "seen.csv")
    assert all(0.8 < row["standardised_rms"] < 1.2 for row in errors("seen.csv").values())


def test_a_wrong_machine_shows() -> None:
    """Errors of the geometry are far outside the noise of a good tracker."""
    call("simulate-measurement", "out", "--geometry", 0.001, "--noise", 1e-6, "--output", "seen.csv")
    assert max(row["standardised_rms"] for row in errors("seen.csv", "--noise", 1e-6).values()) > 10.0


def test_a_late_clock_is_an_error_of_its_own() -> None:
    """Times that are 10 ms late measure where the machine was then, early ones where it will be: opposite errors."""
    exact = ("simulate-measurement", "out", "--geometry", 0, "--noise", 0, "--output", "seen.csv")
    assert call(*exact, "--clock", 0.01).exit_code == 0
    late = errors("seen.csv", "--noise", 0)
    assert call(*exact, "--clock", -0.01).exit_code == 0
    early = errors("seen.csv", "--noise", 0)
    assert late["z"]["largest"] == pytest.approx(-early["z"]["largest"], rel=0.2)
    assert abs(late["z"]["largest"]) > 1e-5


def test_a_part_of_the_points_is_50_mm_off() -> None:
    """Outliers are as many as asked, and the other points are as they were."""
    exact = ("simulate-measurement", "out", "--geometry", 0, "--noise", 0)
    clean, spoilt = (
        np.loadtxt(call(*exact, *options).stdout.splitlines(), delimiter=",", skiprows=1)[:, 1:].reshape(-1, 3)
        for options in ((), ("--outliers", 0.2))
    )
    off = np.linalg.norm(spoilt - clean, axis=1)
    np.testing.assert_allclose(off[off > 0.0], 0.05, atol=1e-9)
    assert abs((off > 0.0).mean() - 0.2) < 0.1


def test_a_file_says_how_it_was_made() -> None:
    """Beside a simulated measurement there is a file that says that it is one, with seed, errors and reflectors."""
    call("simulate-measurement", "out", "--seed", 4, "--output", "seen.csv")
    facts = json.loads(Path("seen.json").read_text())
    assert facts["simulated"] is True
    assert facts["speed"] == 1.0
    assert facts["period_s"] > 0.0
    assert facts["setting"] == {"geometry_std_m": 2e-4, "seed": 4, "outliers": 0.0}
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


def test_numbers_that_are_none_and_files_that_are_not_ours() -> None:
    """Options that are not finite or in another unit, files without end, and files of other programs are refused."""
    call("simulate-measurement", "out", "--output", "seen.csv")
    Path("mine.json").write_text("{}")
    before = sorted(Path().rglob("*"))
    for arguments, expected in (
        (("measured", "out", "seen.csv", "--reflector-1", "nan", 0, 0), "--reflector-1"),
        (("measured", "out", "seen.csv", "--reflector-2", 0, 400, 50), "look like millimetres"),
        (("measured", "out", "seen.csv", "--noise", "nan"), "--noise"),
        (("measured", "out", "seen.csv", "--noise", "1e-320"), "noise"),
        (("simulate-measurement", "out", "--reflector-1", "inf", 0, 0), "--reflector-1"),
        (("simulate-measurement", "out", "--geometry", "nan"), "--geometry"),
        (("simulate-measurement", "out", "--output", "mine.csv"), "mine.json"),
        (("simulate-measurement", "out", "--output", ""), "--output"),
        (("measured", "out", "seen.csv", "--speed", "nan"), "speed"),
        (("measured", "out", "/dev/zero"), "bytes"),
    ):
        result = call(*arguments)
        assert result.exit_code == 2
        assert expected in result.stderr
    assert sorted(Path().rglob("*")) == before
    assert Path("mine.json").read_text() == "{}"
    assert call("simulate-measurement", "out", "--output", "seen.csv").exit_code == 0


@pytest.mark.parametrize("command", ["measured", "simulate-measurement"])
def test_help_has_examples(command: str) -> None:
    """The help of both commands has an example that names it."""
    assert f"gantry-tau {command} results/agder" in call(command, "--help").stdout
