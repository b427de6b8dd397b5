"""The machine and its task, shown."""

import json
from pathlib import Path

import pytest

from pipeline.config import Config
from pipeline.machine import Machine
from pipeline.route import task_endpoints
from tests.cli.calls import Call, edit


class TestCheck:
    """The machine and its task, shown."""

    def test_a_load_too_heavy_for_the_start(self, call: Call, config_file: Path) -> None:
        """It is reported before anything is planned, with the drive, what it needs and what it may take."""
        result = call("check", edit(config_file, machine__dynamics__load_kg=300.0))
        assert result.exit_code == 2
        assert "is valid" not in result.stdout
        message = " ".join(result.stderr.split())
        assert "task.start: needs" in message
        assert "N from c1 to hold the machine; at most 400 N is allowed (its force limit of 400 N)" in message
        assert "kappa" not in message

    def test_reference_machine(self, call: Call, config_file: Path, fast_config: Config, machine: Machine) -> None:
        """Start and goal, grid and limits are shown with units, and nothing is written."""
        result = call("check", config_file)
        assert result.exit_code == 0
        start, _ = task_endpoints(fast_config, machine)
        for text in (
            "5 actuators, 5 degrees of freedom",
            f"{start.kappa:.3f}",
            f"{start.q_m[1]:.4f}",
            f"{17 * 15 * 7 * 7 * 8:,} candidates",
            "acceleration m/s^2",
            "0.95 to 1.25",
            "not checked",
            "is valid",
        ):
            assert text in result.stdout
        assert result.stderr == ""
        assert not Path("results").exists()

    @pytest.mark.parametrize(
        ("locked", "expected"),
        [(["rx"], "4 degrees of freedom in this task (x, y, z, rz); rx held at zero"), (["rx", "rz"], "3 degrees")],
    )
    def test_locked_axes(self, call: Call, config_file: Path, locked: list[str], expected: str) -> None:
        """Locked axes are not degrees of freedom."""
        text = " ".join(call("check", edit(config_file, task__locked_axes=locked)).stdout.split())
        assert expected in text

    def test_a_cap_below_the_ends(self, call: Call, config_file: Path) -> None:
        """A cap on the path's kappa below that of the start is reported before anything is computed."""
        result = call("check", edit(config_file, refine__kappa_max=10.0))
        assert result.exit_code == 2
        assert "refine.kappa_max" in result.stderr

    def test_rail_clearance(self, call: Call, config_file: Path) -> None:
        """A distance to rails that is asked for is shown as a limit."""
        result = call("check", edit(config_file, machine__clearance__link_rail_m=0.05))
        assert ">= 0.05" in result.stdout

    def test_schema(self, call: Call, tmp_path: Path) -> None:
        """The schema is pure JSON, names every key, and refuses unknown ones."""
        schema = json.loads(call("check", "--schema").stdout)
        sections = {"name", "machine", "task", "route", "refine", "certify", "retime", "export"}
        assert set(schema["properties"]) == sections
        assert schema["additionalProperties"] is False
        assert "$defs" in schema
