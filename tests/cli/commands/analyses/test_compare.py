"""The paths of a run, and several runs, compared."""

import json
from pathlib import Path

import pytest

from tests.cli.calls import ESCAPE, Call, edit
from tests.run.fake_stages import FakeStages


class TestCompare:
    """The command `compare`."""

    @pytest.fixture(autouse=True)
    def _run(self, call: Call, config_file: Path, stages: FakeStages) -> None:
        call("run", edit(config_file, retime__jerk=False), "--out", "out")

    def test_compare(self, call: Call) -> None:
        """The table shows both paths."""
        result = call("compare", "out")
        assert result.exit_code == 0
        assert "kappa integral" in result.stdout
        assert "refined" in result.stdout
        assert ESCAPE not in result.output

    def test_compare_markdown(self, call: Call) -> None:
        """Markdown goes to stdout alone."""
        assert call("compare", "out", "--markdown").stdout.startswith("| figure | unit |")

    def test_compare_json(self, call: Call) -> None:
        """JSON has the figures of the summary, unrounded."""
        rows = {row["figure"]: row for row in json.loads(call("compare", "out", "--json").stdout)}
        path = json.loads(Path("out/summary.json").read_text())["path"]
        assert rows["kappa integral"]["refined"] == path["kappa_integral"]
        assert rows["kappa integral"]["coarse"] == path["coarse_kappa_integral"]

    def test_compare_in_time(self, call: Call, config_file: Path) -> None:
        """Both paths are timed, unless that is not wanted or cannot be done."""
        names = [row["figure"] for row in json.loads(call("compare", "out", "--json").stdout)]
        assert "duration" in names
        names = [row["figure"] for row in json.loads(call("compare", "out", "--json", "--no-timing").stdout)]
        assert "duration" not in names
        call("run", edit(config_file, machine__dynamics__friction={"carts_n": 1e3}), "--out", "stuck")
        result = call("compare", "stuck")
        assert result.exit_code == 0
        assert "duration" not in result.stdout
        assert result.stderr.count("a path is compared without its duration") == 2

    def test_compare_tells_what_is_not_certified(self, call: Call, config_file: Path) -> None:
        """A path without a certificate can be compared, and is said to have none; one that has is not spoken of."""
        call("refine", config_file, "--out", "other")
        result = call("compare", "out", "other", "--no-timing")
        assert result.exit_code == 0
        assert result.stderr.count("not certified") == 1
        assert "other: the refined path is not certified" in result.stderr

    def test_compare_runs(self, call: Call, config_file: Path) -> None:
        """Runs of one name are told apart by their folders; equal runs have no difference."""
        call("run", config_file, "--out", "other")
        result = call("compare", "out", "other", "out")
        assert result.exit_code == 0
        assert "against the first run" in result.stdout
        told = json.loads(call("compare", "out", "other", "--json").stdout)
        assert told["runs"] == ["out", "other"]
        assert {row["differences"][1] for row in told["rows"]} == {0.0}
        assert {"kappa integral", "duration", "working-mode changes"} <= {row["figure"] for row in told["rows"]}
        assert call("compare", "out", "other", "--markdown").stdout.startswith("| figure | unit | out | other | best |")

    def test_kappa_of_one_length(self, call: Call, config_file: Path) -> None:
        """Runs whose moments are divided by other lengths are compared with the length of the first one."""
        call("run", edit(config_file, machine__characteristic_length_m=0.3, name="short"), "--out", "short")
        rows = json.loads(call("compare", "out", "short", "--json", "--no-timing").stdout)["rows"]
        same = next(row for row in rows if row["figure"] == "largest kappa")
        assert same["differences"][1] == pytest.approx(0.0, abs=1e-9)

    def test_damaged_results(self, call: Call) -> None:
        """Results edited by hand are not shown as the run's."""
        Path("out/path.npz").write_bytes(b"mine")
        result = call("compare", "out")
        assert result.exit_code == 2
        assert "path.npz" in result.stderr
