"""The command that measures the usable workspace."""

import json
from pathlib import Path

import pytest

from tests.cli.calls import invoke as call

AGDER = Path(__file__).parents[4] / "configs" / "agder.yaml"


def test_table() -> None:
    """The table has a row per working mode and the union, and says what it was computed for."""
    result = call("workspace", AGDER, "--step", 0.05, "--rx", -10)
    assert result.exit_code == 0
    for text in ("LLL", "RRR", "union", "rx -10 deg", "kappa at most 40", "grid step 0.05 m"):
        assert text in result.stdout


def test_json() -> None:
    """The same as JSON: setting, rows and the two ratios."""
    data = json.loads(call("workspace", AGDER, "--step", 0.02, "--json").stdout)
    assert [row["mode"] for row in data["rows"]][-1] == "union"
    assert data["setting"]["kappa_max"] == 40.0
    assert data["setting"]["link_rail_m"] is None
    assert 1.9 < data["union_over_rrr"] < data["union_over_lll"] < 2.0


@pytest.mark.parametrize(("ending", "begin"), [("png", b"\x89PNG"), ("pdf", b"%PDF"), ("svg", b"<?xml")])
def test_picture(tmp_path: Path, ending: str, begin: bytes) -> None:
    """The picture is written in the format its name ends with, and reported on stderr."""
    picture = tmp_path / f"maps.{ending}"
    result = call("workspace", AGDER, "--step", 0.1, "--picture", picture)
    assert result.exit_code == 0
    assert picture.read_bytes().startswith(begin)
    assert str(picture) in result.stderr


def test_picture_in_3d(tmp_path: Path) -> None:
    """The 3-D picture can be had beside the maps."""
    maps, volume = tmp_path / "maps.png", tmp_path / "volume.png"
    result = call("workspace", AGDER, "--step", 0.1, "--picture", maps, "--picture-3d", volume)
    assert result.exit_code == 0
    assert maps.read_bytes()[:8] == volume.read_bytes()[:8]
    assert "in 3-D" in result.stderr


@pytest.mark.parametrize(
    "options",
    [("--picture", "maps.gif"), ("--picture-3d", "volume.txt"), ("--step", 0), ("--rx", 90), ("--kappa-max", 0.5)],
)
def test_bad_options(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, options: tuple[object, ...]) -> None:
    """What cannot be computed or written is refused as bad usage before anything is done."""
    monkeypatch.chdir(tmp_path)
    result = call("workspace", AGDER, *options)
    assert result.exit_code == 2
    assert list(tmp_path.iterdir()) == []


def test_help_has_examples() -> None:
    """The help names the command in its examples."""
    assert "gantry-tau workspace configs/agder.yaml" in call("workspace", "--help").stdout
