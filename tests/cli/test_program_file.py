"""The program of a task as a file."""

from io import StringIO
from pathlib import Path

import highspy
import pytest
from rich.console import Console
from typer.testing import CliRunner

from pipeline.cli import app
from pipeline.cli.program_file import write_program
from pipeline.config import Config
from pipeline.config.file import dump_config
from pipeline.errors import UsageError
from pipeline.machine import build_machine
from pipeline.route import build_regions, plan_route


@pytest.fixture(scope="module")
def small(quick_config: Config, change) -> Config:
    """Make a task of few regions, from LLL to RLL by way of a box, with the compact program."""
    pose = {"x_m": 1.02, "y_m": 0.6, "z_m": 0.6}
    axis = {"min": 0.5, "max": 0.7, "step": 0.1}
    return change(
        quick_config,
        task__start={**pose, "mode": "LLL"},
        task__goal={**pose, "mode": "RLL"},
        task__visit=[{"box": {"y_m": [0.45, 0.55], "z_m": [0.65, 0.75]}, "modes": ["RLL"]}],
        task__locked_axes=["rx", "rz"],
        route__grid__y_m=axis,
        route__grid__z_m=axis,
        route__step_budget=5,
        route__formulation="compact",
        route__objective="sum",
    )


def optimum(config: Config, path: Path) -> tuple[float, str]:
    """Write a program, have it solved from the file, and give its optimum and what was said."""
    said = StringIO()
    write_program(config, path, Console(file=said, width=200))
    solver = highspy.Highs()
    solver.setOptionValue("output_flag", False)
    solver.readModel(str(path))
    solver.run()
    return solver.getInfo().objective_function_value, said.getvalue()


def test_the_file_is_the_program_that_is_solved(tmp_path: Path, small: Config, change) -> None:
    """Its optimum is the route's, visits included: they cost something here, and add regions."""
    machine = build_machine(small.machine)
    regions = build_regions(small, machine)
    best = plan_route(small, machine, regions)
    found, said = optimum(small, tmp_path / "visits.mps")
    assert found == pytest.approx(best.objective, abs=1e-5)
    assert int(said.split(" regions")[0]) > len(regions)
    free, said = optimum(change(small, task__visit=[]), tmp_path / "free.mps")
    assert free < found - 1.0
    assert int(said.split(" regions")[0]) < len(regions)


@pytest.mark.parametrize(
    ("changes", "name", "message"),
    [
        ({"formulation": "core"}, "p.mps", "goes with --formulation paper"),
        ({"objective": "bottleneck"}, "p.mps", r"goes with route\.objective sum"),
        ({"alternative": 2}, "p.mps", r"goes with route\.alternative 1"),
        ({}, "p.txt", r"must end in \.mps"),
    ],
)
def test_what_is_not_one_program_is_refused(
    tmp_path: Path, small: Config, change, changes: dict[str, object], name: str, message: str
) -> None:
    """The key is named, and nothing is written."""
    config = change(small, **{f"route__{key}": value for key, value in changes.items()})
    with pytest.raises(UsageError, match=message):
        write_program(config, tmp_path / name, Console(file=StringIO()))
    assert not (tmp_path / name).exists()


def test_alternatives_are_refused(tmp_path: Path, small: Config) -> None:
    """--alternatives asks for several routes."""
    path = tmp_path / "small.yaml"
    path.write_text(dump_config(small))
    arguments = ["route", str(path), "--alternatives", "2", "--write-mps", str(tmp_path / "p.mps")]
    result = CliRunner().invoke(app, arguments)
    assert result.exit_code == 2
    assert "--write-mps goes with --alternatives 1" in result.stderr
    assert not (tmp_path / "p.mps").exists()
