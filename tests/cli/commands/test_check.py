"""The machine and its task, shown."""

import json
from pathlib import Path

import pytest
import yaml

from pipeline.config import Config
from pipeline.machine import Machine
from pipeline.route import task_endpoints
from tests.cli.calls import Call, edit
from tests.scaling import scaled


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

    def test_a_refused_start_is_shown_all_the_same(self, call: Call, config_file: Path) -> None:
        """The tables and the picture come first, the refusal last; what is out of reach has no column."""
        heavy = edit(config_file, machine__dynamics__load_kg=300.0)
        refused = call("check", heavy, "--picture", "refused.png")
        assert refused.exit_code == 2
        for text in ("Actuators", "Reach without tilt", "c1 holds", "refused.png: the machine at start and goal"):
            assert text in refused.stdout
        assert Path("refused.png").is_file()
        assert f"{heavy} cannot be used" in refused.stderr
        far = call("check", edit(config_file, task__goal__y_m=5.0))
        assert far.exit_code == 2
        assert "Reach without tilt" in far.stdout
        assert "sign of det H" not in far.stdout
        assert "task.goal: is out of reach" in far.stderr

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

    def test_a_picture_of_start_and_goal(self, call: Call, config_file: Path) -> None:
        """It is written on request; a name that is no picture's is refused before anything is checked."""
        result = call("check", config_file, "--picture", "machine.png")
        assert result.exit_code == 0
        assert "machine.png: the machine at start and goal" in result.stdout
        assert Path("machine.png").read_bytes().startswith(b"\x89PNG")
        refused = call("check", config_file, "--picture", "machine.txt")
        assert refused.exit_code == 2
        assert "machine.txt: the name of the file must end in one of .png" in refused.stderr

    @pytest.mark.parametrize(
        ("locked", "expected"),
        [(["rx"], "4 degrees of freedom in this task (x, y, z, rz); rx held at zero"), (["rx", "rz"], "3 degrees")],
    )
    def test_locked_axes(self, call: Call, config_file: Path, locked: list[str], expected: str) -> None:
        """Locked axes are not degrees of freedom."""
        text = " ".join(call("check", edit(config_file, task__locked_axes=locked)).stdout.split())
        assert expected in text

    def test_limits_of_single_drives_and_of_push_and_pull(self, call: Call, config_file: Path) -> None:
        """Every drive has a line of its own, and both forces."""
        cart = {"velocity_mps": 0.5, "acceleration_mps2": 2.0, "force_n": 400.0}
        carts = {"c1": cart, "c2": {**cart, "velocity_mps": 0.4}, "c3": {**cart, "force_n": {"push": 300, "pull": 500}}}
        changes = {"carts": carts, "link_force_n": {"push": 1500, "pull": 2000}}
        file = edit(config_file, **{f"machine__limits__{key}": value for key, value in changes.items()})
        lines = [" ".join(line.split()) for line in call("check", file).stdout.splitlines()]
        for expected in (
            "│ c2 │ 0.4 │ 2 │ - │ 400 │",
            "│ c3 │ 0.5 │ 2 │ - │ push 300, pull 500 │",
            "│ links │ - │ - │ - │ push 1500, pull 2000 │",
        ):
            assert expected in lines
        text = "\n".join(lines)
        assert "│ c3 holds │ N │ 109.8 │ -89.7 │ -500 to 300 │" in text
        assert "│ any link, pushed holds │ N │ 190.2 │ 153.6 │ <= 1500 │" in text
        assert "│ any link, pulled holds │ N │ -171.5 │ -149.7 │ >= -2000 │" in text

    def test_margins_that_the_task_does_not_leave(self, call: Call, config_file: Path) -> None:
        """The range of the path is shown, and the drive, the pose and the distance that is left are told."""
        assert "Note" not in call("check", config_file).stdout
        text = " ".join(call("check", edit(config_file, refine__travel_margin_m=0.03)).stdout.split())
        assert "task.start has c1 at 0.0202 m, 20.2 mm from the end of its rail" in text
        assert "instead of refine.travel_margin_m (30 mm)" in text
        assert "│ 0 │ 2.1 │ 0.0201727 │ 2.07 │" in text

    def test_a_machine_in_another_size(self, call: Call, config_file: Path, quick_config: Config) -> None:
        """A large kappa at the start is warned of; the length that is advised brings the paper's kappa back."""
        small = scaled(quick_config, 0.1).model_dump(mode="json")
        small["machine"]["characteristic_length_m"] = 1.0
        config_file.write_text(yaml.safe_dump(small))
        refused = " ".join(call("check", config_file).stderr.split())
        assert "has kappa 216.3, above route.kappa_max (100); with machine.characteristic_length_m: 0.12" in refused
        warned = " ".join(call("check", edit(config_file, route__kappa_max=500)).stdout.split())
        assert "Warning: kappa at the start is 216, more than a third of route.kappa_max (500)" in warned
        assert "with 0.12, the mean length of the links, kappa would be 27.2 there" in warned
        fitting = call("check", edit(config_file, machine__characteristic_length_m=0.12))
        assert fitting.exit_code == 0
        assert "Warning" not in fitting.stdout

    def test_a_start_near_a_singularity(self, call: Call, config_file: Path) -> None:
        """Where no length helps, none is advised."""
        warned = " ".join(call("check", edit(config_file, route__kappa_max=30)).stdout.split())
        assert (
            "leaves routes little room; raise route.kappa_max, or give the task a start farther from singularities"
            in warned
        )

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
        sections = {
            "name",
            "machine",
            "task",
            "route",
            "refine",
            "certify",
            "bound",
            "retime",
            "figures",
            "export",
            "drives",
            "atlas",
        }
        assert set(schema["properties"]) == sections
        assert schema["additionalProperties"] is False
        assert "$defs" in schema
