"""The command that proves how far the tool may be off."""

import json
from pathlib import Path

import numpy as np
import pytest

from pipeline.inclusion.uncertainty import Uncertainty
from pipeline.pose_error import DriveAmplification, PoseError
from tests.cli.calls import Call

GAINS = np.array([2.0, 2.0, 2.0, 4.0, 5.0])


@pytest.fixture(autouse=True)
def _run(call: Call, config_file: Path) -> None:
    """Run fake stages into the folder `out` of an empty folder."""
    assert call("run", config_file, "--out", "out").exit_code == 0


@pytest.fixture
def quick(monkeypatch: pytest.MonkeyPatch) -> None:
    """Take the proof for one that costs nothing."""

    def bound(path: object, errors: Uncertainty, *_: object) -> PoseError:
        size = 3.0 * errors.coordinate_m + float(GAINS @ errors.actuator_m)
        gains = DriveAmplification(GAINS[None], GAINS[None])
        return PoseError(errors, np.array([0.0, 1.0]), np.array([size]), np.array([2.0 * size]), gains)

    monkeypatch.setattr("pipeline.pose_error.bound_pose_error", bound)


def test_it_proves_and_draws(call: Call) -> None:
    """A table with a row per drive, a sentence, the bound over s, and a picture."""
    options = ("--drives-mm", "0.1,0.1,0.1,0.05,0", "--output", "error.csv", "--picture", "error.png")
    result = call("pose-error", "out", *options)
    assert result.exit_code == 0, result.output
    assert "the tool is off by at most" in result.stdout
    assert "0.05" in result.stdout
    assert Path("error.csv").read_text().startswith("s_first,s_last,position_m,rotation_rad,amplification_c1")
    assert Path("error.png").read_bytes()[:4] == b"\x89PNG"


@pytest.mark.usefixtures("quick")
def test_errors_are_those_that_are_given_or_configured(call: Call) -> None:
    """Without any there is nothing to prove; millimetres become metres."""
    found = json.loads(call("pose-error", "out", "--drives-mm", 0.1, "--coordinates-mm", 0.02, "--json").stdout)
    assert found["errors"]["actuator_m"] == pytest.approx([1e-4] * 5)
    assert found["errors"]["coordinate_m"] == pytest.approx(2e-5)
    assert found["pose_error_bound_m"] == pytest.approx(15e-4 + 6e-5)
    nothing = call("pose-error", "out")
    assert nothing.exit_code == 2
    assert "certify.pose_error is null in out" in nothing.stderr
    zero = call("pose-error", "out", "--drives-mm", 0)
    assert zero.exit_code == 2
    assert "all errors given are 0" in zero.stderr
    for told in (nothing, zero):
        assert "give a --drives-mm, --lengths-mm or --coordinates-mm above 0." in told.stderr


@pytest.mark.usefixtures("quick")
def test_all_that_is_off_is_shown(call: Call) -> None:
    """Errors of the geometry have rows, too."""
    shown = call("pose-error", "out", "--coordinates-mm", 0.05, "--lengths-mm", 0.02).stdout
    rows = [[cell.strip() for cell in line.split("│")] for line in shown.splitlines()]
    assert [row[1:3] for row in rows if len(row) > 2][-2:] == [["every length", "0.02"], ["every coordinate", "0.05"]]


@pytest.mark.usefixtures("quick")
def test_an_accuracy_asks_for_drives(call: Call) -> None:
    """A row per kind, beside errors of the geometry; those that take all of it are refused."""
    found = json.loads(call("pose-error", "out", "--accuracy-mm", 0.5, "--json").stdout)
    assert set(found["tolerances"]) == {"all_alike", "equal_shares", "c1", "c2", "c3", "l2b", "l3b"}
    assert all(4.9e-4 < one["bound_m"] <= 5e-4 for one in found["tolerances"].values())
    assert "l3b alone" in call("pose-error", "out", "--accuracy-mm", 0.5, "--coordinates-mm", 0.1).stdout
    refused = call("pose-error", "out", "--accuracy-mm", 0.5, "--coordinates-mm", 0.2)
    assert refused.exit_code == 1
    assert "geometry alone" in refused.stderr


@pytest.mark.parametrize(
    ("options", "told"),
    [
        (("--drives-mm", "a"), "expected one error from 0 to 100 mm, or five"),
        (("--drives-mm", "0.1,0.2"), "expected one error from 0 to 100 mm, or five"),
        (("--drives-mm", "nan"), "expected one error from 0 to 100 mm, or five"),
        (("--drives-mm", "-1"), "expected one error from 0 to 100 mm, or five"),
        (("--accuracy-mm", 0.1, "--drives-mm", 0.1), "it excludes --drives-mm"),
        (("--drives-mm", 0.1, "--output", "out/error.csv"), "is inside out"),
        (("--drives-mm", 0.1, "--picture", "error.txt"), "must end in one of"),
    ],
)
def test_bad_options_are_refused(call: Call, options: tuple[object, ...], told: str) -> None:
    """With exit code 2 and what is allowed."""
    result = call("pose-error", "out", *options)
    assert result.exit_code == 2
    assert told in result.stderr
