"""The state of the page: valid after every change, and unchanged by one that is refused."""

from pathlib import Path

import pytest

from pipeline.config import Config
from pipeline.errors import ConfigError, UsageError
from pipeline.show.edits import with_machine
from pipeline.show.session import Session, is_run_folder


def test_another_machine_stands_at_the_same_pose(quick_config: Config) -> None:
    """Longer rails leave the pose, and change what its limits read."""
    session = Session(quick_config, Path("quick.yaml"))
    session.jog(quick_config.task.start.model_copy(update={"x_m": 1.3}))
    session.edit(lambda config: with_machine(config, {"rails.0.travel_m": [0.0, 2.6]}))
    assert session.machine.travel_m[0, 1] == 2.6
    assert session.posture.asked.x_m == 1.3
    assert {one.name: one.largest for one in session.posture.readings}["c1"] == 2.6


def test_a_refused_change_changes_nothing(quick_config: Config) -> None:
    """A machine that can be nowhere, or values out of bounds, leave everything as it was."""
    session = Session(quick_config, Path("quick.yaml"))
    machine, posture = session.machine, session.posture
    for values in ({"rails.0.y_m": -6.0}, {"rails.0.travel_m": [1.0, 0.0]}):
        with pytest.raises(ConfigError):
            session.edit(lambda config, values=values: with_machine(config, values))
    assert session.config is quick_config
    assert session.machine is machine
    assert session.posture is posture


def test_a_file_that_holds_the_task_is_not_written(quick_config: Config, tmp_path: Path) -> None:
    """Planning saves what was changed, and leaves a file alone that says the same."""
    path = tmp_path / "mine.yaml"
    session = Session(quick_config, path)
    session.require_file(path, replace=False)
    written = path.read_bytes()
    path.write_bytes(written + b"# a remark\n")
    session.require_file(path, replace=False)
    assert path.read_bytes().endswith(b"# a remark\n")
    session.edit(lambda config: with_machine(config, {"rails.0.travel_m": [0.0, 2.2]}))
    with pytest.raises(UsageError, match="is there already"):
        session.require_file(path, replace=False)
    assert session.config.name == "mine"


def test_what_is_opened_has_to_be_there(tmp_path: Path) -> None:
    """A folder is one of a run, a file is a configuration, anything else is refused."""
    assert is_run_folder(tmp_path)
    with pytest.raises(UsageError, match="does not exist"):
        is_run_folder(tmp_path / "none")
