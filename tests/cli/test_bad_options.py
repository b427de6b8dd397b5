"""Whatever options a command is given: one message that names the option, exit code 2, no traceback."""

import shutil
from pathlib import Path
from typing import Any

import pytest
import typer

from pipeline.cli import app
from pipeline.config import Config
from pipeline.config.file import dump_config
from tests.cli.calls import Call, invoke
from tests.run.fake_stages import FakeStages

NUMBERS = [
    (command.name, parameter.opts[-1], parameter.nargs)
    for command in typer.main.get_command(app).commands.values()
    for parameter in command.params
    if "float" in str(parameter.type_descriptor.annotation)
]
"""Every option of every command that takes numbers, however many."""


def test_the_commands_have_such_options() -> None:
    """The list is not empty by mistake."""
    assert {"--period", "--speed", "--noise", "--reflector-1", "--kappa-max", "--step", "--blend"} <= {
        option for _, option, _ in NUMBERS
    }


@pytest.mark.parametrize("value", ["nan", "inf", "-inf", "1e400", "soon", ""])
@pytest.mark.parametrize(("command", "option", "count"), NUMBERS)
def test_numbers_are_finite(command: str, option: str, count: int, value: str) -> None:
    """No bound stops a NaN, so that all options refuse it before anything else happens."""
    given = [value, *["0"] * (count - 1)]
    arguments = ["x", "y"] if command in ("measured", "calibrate") else ["x"]
    result = invoke(command, *arguments, option, *given)
    assert result.exit_code == 2
    assert option in result.stderr
    assert result.stdout == ""


WRONG: tuple[tuple[tuple[Any, ...], str], ...] = (
    (("run", "none.yaml"), "none.yaml"),
    (("run", "c.yaml", "--to", "regionss"), "--to"),
    (("run", "c.yaml", "--from", "retime", "--to", "regions"), "--from retime comes after --to regions"),
    (("run", "c.yaml", "--from", "retime", "--out", "empty"), "--from retime needs earlier results"),
    (("run", "c.yaml", "--speed", "0"), "a speed of 0"),
    (("run", "c.yaml", "--speed", "-1"), "a speed of -1"),
    (("run", "c.yaml", "--speed", "5e-324"), "retime.speed"),
    (("run", "c.yaml", "--speed", "1.0000001"), "retime.speed"),
    (("retime", "c.yaml", "--speed", "1e300"), "retime.speed"),
    (("run", "c.yaml", "--out", "c.yaml"), "c.yaml"),
    (("run", "c.yaml", "--out", ""), "--out"),
    (("run", "c.yaml", "c.yaml"), "c.yaml"),
    (("route", "c.yaml", "--alternatives", "0"), "--alternatives"),
    (("route", "c.yaml", "--alternatives", "11"), "--alternatives"),
    (("route", "c.yaml", "--alternatives", "9" * 5000), "--alternatives"),
    (("route", "c.yaml", "--alternatives", "2", "--write-mps", "p.mps"), "--alternatives"),
    (("route", "c.yaml", "--formulation", "short"), "--formulation"),
    (("route", "c.yaml", "--write-mps", "p.mps"), "--formulation"),
    (("route", "c.yaml", "--write-mps", "p.mps", "--formulation", "paper"), "route.objective"),
    (("certify",), "CONFIG"),
    (("certify", "c.yaml", "--check", "out"), "--check"),
    (("certify", "--check", "none"), "none"),
    (("certify", "--check", "c.yaml"), "c.yaml"),
    (("check",), "CONFIG"),
    (("compare",), "RUN"),
    (("compare", "out", "--json", "--markdown"), "exclude"),
    (("compare", "none"), "none does not exist"),
    (("compare", "c.yaml"), "c.yaml is not a run folder"),
    (("compare", "out", "none"), "none does not exist"),
    (("compare", "out", "--blend", "0"), "--blend"),
    (("compare", "out", "--blend", "101"), "--blend"),
    (("export", "none"), "none does not exist"),
    (("export", "out", "--period", "0"), "a period of 0"),
    (("export", "out", "--period", "1e-9"), "retime.period_s"),
    (("export", "out", "--period", "5e-324"), "retime.period_s"),
    (("export", "out", "--period", "1e300"), "retime.period_s"),
    (("export", "out", "--speed", "5e-324"), "retime.speed"),
    (("export", "out", "--speed", "0.001", "--period", "0.000125"), "retime.period_s"),
    (("export", "out", "--decimals", "-1"), "--decimals"),
    (("export", "out", "--decimals", "1e3"), "--decimals"),
    (("export", "out", "--columns", "t_s,colour"), "colour"),
    (("export", "out", "--columns", "t_s,t_s"), "t_s"),
    (("export", "out", "--columns", ","), "column"),
    (("export", "out", "--columns", "\x1b[31m"), "\\x1b[31m"),
    (("export", "out", "--format", "ros2", "--columns", "t_s"), "columns"),
    (("export", "out", "--format", "linuxcnc", "--separator", "tab"), "separator"),
    (("export", "out", "--format", "mujoco"), "mujoco"),
    (("export", "out", "--decimal", "comma"), "--decimal comma"),
    (("export", "out", "--names", "a"), "--names"),
    (("export", "out", "--format", "pvt", "--times", "since"), "--times"),
    (("export", "out", "--format", "ros2", "--lead-in", "nan"), "--lead-in"),
    (("export", "out", "--format", "cam", "--tolerance", "-1"), "--tolerance"),
    (("export", "out", "--length", "inch"), "--length"),
    (("export", "out", "--output", "out/mine.csv"), "out/mine.csv"),
    (("export", "out", "--output", ""), "--output"),
    (("export", "out", "--output", "c.yaml/mine.csv"), "c.yaml"),
    (("report", "none"), "none does not exist"),
    (("report", "out", "--output", "out/other.html"), "out/other.html"),
    (("measured", "out"), "FILE"),
    (("measured", "out", "none.csv"), "none.csv"),
    (("measured", "out", "c.yaml"), "c.yaml"),
    (("measured", "out", "out"), "out"),
    (("measured", "out", "seen.csv", "--reflector-1", "0", "0"), "--reflector-1"),
    (("measured", "out", "seen.csv", "--reflector-1", "1e308", "0", "0"), "reflector 1"),
    (("measured", "out", "seen.csv", "--noise", "-1"), "--noise"),
    (("measured", "out", "seen.csv", "--noise", "1"), "--noise"),
    (("measured", "out", "seen.csv", "--picture", "seen.bmp"), "--picture"),
    (("measured", "out", "seen.csv", "--speed", "0"), "speed"),
    (("simulate-measurement", "out", "--geometry", "1"), "--geometry"),
    (("simulate-measurement", "out", "--seed", "-1"), "--seed"),
    (("simulate-measurement", "out", "--seed", "1.5"), "--seed"),
    (("simulate-measurement", "out", "--output", "x.json"), "x.json"),
    (("simulate-measurement", "out", "--outliers", "0.6"), "--outliers"),
    (("simulate-measurement", "out", "--clock", "2"), "--clock"),
    (("simulate-poses", "c.yaml"), "--reflector-1"),
    (("simulate-poses", "c.yaml", "--reflector-1", "0", "100", "50"), "millimetres"),
    (("simulate-poses", "c.yaml", "--reflector-1", "0", "0", "0", "--reflector-3", "0", "1", "0"), "--reflector-2"),
    (("simulate-poses", "c.yaml", "--reflector-1", "0", "0", "0", "--poses", "0"), "--poses"),
    (("calibrate", "c.yaml", "--reflector-1", "0", "0", "0"), "FILE"),
    (("calibrate", "c.yaml", "seen.csv"), "--reflector-1"),
    (("calibrate", "c.yaml", "none.csv", "--reflector-1", "0", "0", "0"), "none.csv"),
    (("calibrate", "c.yaml", "seen.csv", "--reflector-1", "0", "0", "0", "--fit", "rails,masses"), "masses"),
    (("calibrate", "c.yaml", "seen.csv", "--reflector-1", "0", "0", "0", "--fit", ","), "--fit"),
    (("calibrate", "c.yaml", "seen.csv", "--reflector-1", "0", "0", "0", "--prior", "masses=1e-4"), "--prior"),
    (("calibrate", "c.yaml", "seen.csv", "--reflector-1", "0", "0", "0", "--prior", "0"), "--prior"),
    (("calibrate", "c.yaml", "seen.csv", "--reflector-1", "0", "0", "0", "--hold-out", "1"), "--hold-out"),
    (("calibrate", "c.yaml", "seen.csv", "--reflector-1", "0", "0", "0", "--output", "c.yaml"), "c.yaml"),
    (("calibrate", "c.yaml", "seen.csv", "--reflector-1", "0", "0", "0", "--output", "x.json"), "x.json"),
    (("tradeoff", "c.yaml", "--weights", ""), "--weights"),
    (("tradeoff", "c.yaml", "--weights", "3,fast"), "--weights"),
    (("tradeoff", "c.yaml", "--weights", "3,0"), "--weights"),
    (("tradeoff", "c.yaml", "--weights", "0", "--weights", "3"), "--weights"),
    (("tradeoff", "c.yaml", "--weights", "nan"), "--weights"),
    (("tradeoff", "c.yaml", "--weights", "1001"), "--weights"),
    (("tradeoff", "c.yaml", "--routes", "11"), "--routes"),
    (("tradeoff", "c.yaml", "--picture", "curves.gif"), "--picture"),
    (("workspace", "c.yaml", "--step", "0"), "--step"),
    (("workspace", "c.yaml", "--step", "1e-9"), "--step"),
    (("workspace", "c.yaml", "--rx", "90"), "--rx"),
    (("workspace", "c.yaml", "--kappa-max", "0.5"), "--kappa-max"),
    (("workspace", "c.yaml", "--picture", "map"), "--picture"),
    (("workspace", "c.yaml", "--picture-3d", "map.gif"), "--picture-3d"),
    (("fly",), "fly"),
    (("--unknown",), "--unknown"),
)


@pytest.fixture(scope="module")
def finished(tmp_path_factory: pytest.TempPathFactory, quick_config: Config) -> Path:
    """Run fake stages once, beside the configuration and a measurement."""
    folder = tmp_path_factory.mktemp("finished")
    (folder / "c.yaml").write_text(dump_config(quick_config), encoding="utf-8")
    (folder / "seen.csv").write_text("t_s,x_m,y_m,z_m,rx_rad,rz_rad\n0,0,0,0,0,0\n1,0,0,0,0,0\n", encoding="utf-8")
    FakeStages().run(quick_config, folder / "out")
    return folder


@pytest.fixture
def bad_folder(finished: Path) -> None:
    """Give each test a copy of the run in its empty folder."""
    shutil.copytree(finished, ".", dirs_exist_ok=True)


@pytest.mark.parametrize(("arguments", "expected"), WRONG, ids=lambda value: " ".join(map(str, value))[:60])
def test_wrong_options_are_refused(call: Call, bad_folder: None, arguments: tuple[Any, ...], expected: str) -> None:
    """The message names what is wrong, and nothing is printed as a result."""
    result = call(*arguments)
    assert result.exit_code == 2
    assert expected in result.stderr.replace("\n", " ")
    assert "Traceback" not in result.output
    assert result.stdout == ""
