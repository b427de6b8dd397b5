"""Bad input ends with one clear message, exit code 2 and earlier results untouched."""

from pathlib import Path
from typing import Any

import pytest

from tests.cli.calls import Call, edit
from tests.run.fake_stages import FakeStages


class TestBadInput:
    """Bad input ends with one clear message, exit code 2 and earlier results untouched."""

    @pytest.mark.parametrize(
        ("changes", "expected"),
        [
            ({"machine__rails__0__colour": "red"}, "machine.rails[0].colour"),
            ({"route__grid__y_m__stepp": 0.1}, "did you mean step"),
            ({"machine__rails__0__travel_m": [0.0, 2100]}, "millimetres"),
            ({"machine__limits__carts__velocity_mps": -0.5}, "machine.limits.carts.velocity_mps"),
            ({"machine__links__l1__length_m": -1.09}, "machine.links.l1.length_m"),
            ({"task__start__y_m": 1.9}, "task.start: is out of reach"),
            ({"task__start__x_m": 0.1}, "needs c1 at"),
            ({"task__goal__mode": "LXR"}, "task.goal.mode"),
            ({"task__goal__mode": "RRL"}, "task.goal"),
            ({"task__tilt_max_deg": "much"}, "task.tilt_max_deg"),
            ({"route__grid__z_m": {"min": 1.0, "max": 0.5, "step": 0.1}}, "the grid is empty"),
            ({"route__grid__z_m__step": 0.0}, "route.grid.z_m.step"),
            ({"retime__period_s": 10.0}, "retime.period_s"),
        ],
    )
    def test_bad_values(
        self, call: Call, config_file: Path, stages: FakeStages, changes: dict[str, Any], expected: str
    ) -> None:
        """Every bad value is reported with its key, by every command that reads it, before anything is changed."""
        bad = edit(config_file, **changes)
        for command in ("run", "check"):
            result = call(command, bad)
            assert result.exit_code == 2
            assert expected in result.stderr
            assert f"error: {bad} cannot be used" in result.stderr
            # What is wrong with the task only does not keep `check` from showing the machine.
            assert result.stdout == "" or (command == "check" and "degrees of freedom" in result.stdout)
            assert "is valid" not in result.stdout
        assert stages.calls == []
        assert not Path("results").exists()

    def test_earlier_results_stay(self, call: Call, config_file: Path, stages: FakeStages) -> None:
        """A configuration that got worse costs no results."""
        call("run", config_file)
        before = {path: path.read_bytes() for path in Path("results").rglob("*") if path.is_file()}
        assert call("run", edit(config_file, task__goal__y_m=1.9), "--force").exit_code == 2
        assert {path: path.read_bytes() for path in Path("results").rglob("*") if path.is_file()} == before

    @pytest.mark.parametrize(
        ("text", "expected"),
        [
            ("machine: [", "is not valid YAML"),
            ("a: 1\na: 2\n", "given twice"),
            ("", "machine, task and route"),
            ("- 1\n", "machine, task and route"),
            ("name: x\n", "machine: is missing"),
        ],
    )
    def test_bad_files(self, call: Call, tmp_path: Path, text: str, expected: str) -> None:
        """Files that are not configurations at all are refused with the reason."""
        (tmp_path / "bad.yaml").write_text(text)
        result = call("run", "bad.yaml")
        assert result.exit_code == 2
        assert expected in result.stderr
        assert not (tmp_path / "results").exists()

    @pytest.mark.parametrize("name", ["none.yaml", "."])
    def test_no_file(self, call: Call, name: str) -> None:
        """A file that is not there is named."""
        result = call("run", name)
        assert result.exit_code == 2
        assert f"{name} cannot be used" in result.stderr

    @pytest.mark.parametrize(
        "arguments",
        [
            ["run"],
            ["run", "a.yaml", "--from", "certify"],
            ["run", "a.yaml", "--unknown"],
            ["fly", "a.yaml"],
            ["check"],
            ["compare", "x", "--markdown", "--json"],
            ["compare", "x"],
            ["export", "x", "--format", "dwg"],
            ["export", "x", "--period", "soon"],
        ],
    )
    def test_bad_usage(self, call: Call, arguments: list[str]) -> None:
        """Commands that make no sense end with 2 and say why on stderr."""
        result = call(*arguments)
        assert result.exit_code == 2
        assert result.stderr
        assert result.stdout == ""
        assert "Traceback" not in result.output

    def test_from_before_to(self, call: Call, config_file: Path, stages: FakeStages) -> None:
        """An empty range of stages is refused."""
        result = call("run", config_file, "--from", "retime", "--to", "route")
        assert result.exit_code == 2
        assert "--from retime comes after --to route" in result.stderr
