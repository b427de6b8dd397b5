"""The commands of an atlas."""

import json
from pathlib import Path

import pytest

from pipeline.config.file import dump_config, load_config
from tests.conftest import CONFIGS
from tests.run.atlas.conftest import LEFT, LOW, RIGHT


@pytest.fixture
def cell_file(tmp_path: Path, vary) -> Path:
    """Write the task of three stations."""
    path = tmp_path / "cell.yaml"
    config = vary(load_config(CONFIGS / "tiny.yaml"), {"atlas.stations": [LEFT, RIGHT, LOW], "name": "cell"})
    path.write_text(dump_config(config))
    return path


class TestAtlas:
    """`gantry-tau atlas` and `gantry-tau atlas-query`."""

    def test_table_picture_and_query(self, call, cell_file: Path) -> None:
        """The folder is named after the configuration; queries compute nothing."""
        result = call("atlas", cell_file)
        assert result.exit_code == 0
        assert "from \\ to" in result.stdout
        assert "6 pairs of 3 stations, 3 of them searched" in result.stdout
        folder = Path("results/cell-atlas")
        assert (folder / "atlas.png").is_file()
        asked = call("atlas-query", folder, "low", "left")
        assert asked.exit_code == 0
        assert "low to left: optimal, that of left to low backwards" in asked.stdout
        assert str(folder / "routes" / "low--left.csv") in asked.stdout
        assert call("atlas-query", folder).stdout.splitlines()[0] == result.stdout.splitlines()[0]
        pair = json.loads(call("atlas-query", folder, "low", "left", "--json").stdout)
        assert (pair["from"], pair["to"], pair["from_reverse"]) == ("low", "left", True)

    def test_motions(self, call, cell_file: Path) -> None:
        """Runs of their own, which a query names."""
        result = call("atlas", cell_file, "--to", "retime", "--out", "a", "--json", "--picture", "b.svg")
        assert result.exit_code == 0
        assert {pair["motion"]["status"] for pair in json.loads(result.stdout)["pairs"]} == {"done"}
        assert Path("b.svg").is_file()
        asked = call("atlas-query", "a", "right", "left").stdout
        assert "runs/left--right, backwards" in asked
        assert "duration" in asked

    def test_an_open_pair_ends_with_1(self, call, cell_file: Path, vary) -> None:
        """The tables are shown before."""
        cell_file.write_text(dump_config(vary(load_config(cell_file), {"route.time_limit_s": 1e-9})))
        result = call("atlas", cell_file, "--out", "a")
        assert result.exit_code == 1
        assert "time limit" in result.stdout
        assert "6 of 6 pairs are open; left to right: no route was found within" in " ".join(result.stderr.split())
        asked = call("atlas-query", "a", "left", "low")
        assert asked.exit_code == 1
        assert "raise route.time_limit_s" in asked.stderr

    @pytest.mark.parametrize(
        ("arguments", "words"),
        [
            (("atlas", "cell.yaml", "--to", "regions"), "allowed are route and later stages"),
            (("atlas", "cell.yaml", "--picture", "a.gif"), "must end in one of"),
            (("atlas", "cell.yaml", "--out", "cell.yaml"), "needs a folder"),
            (("atlas-query", "nowhere"), "has no atlas.json"),
            (("atlas-query", "nowhere", "a"), "has no atlas.json"),
        ],
    )
    def test_wrong_use(self, call, cell_file: Path, arguments: tuple[str, ...], words: str) -> None:
        """Refused with exit code 2, and nothing is written."""
        before = sorted(Path().rglob("*"))
        result = call(*arguments)
        assert result.exit_code == 2
        assert words in " ".join(result.stderr.split())
        assert sorted(Path().rglob("*")) == before

    def test_a_query_needs_stations_of_the_atlas(self, call, cell_file: Path) -> None:
        """Those there are are named."""
        call("atlas", cell_file, "--out", "a")
        for names, words in ((("left",), "FROM needs TO"), (("left", "mill"), "it has left, right, low")):
            result = call("atlas-query", "a", *names)
            assert result.exit_code == 2
            assert words in " ".join(result.stderr.split())
