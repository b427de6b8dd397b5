"""A run folder changes in one step and loses nothing."""

import os
import subprocess
import sys
import textwrap
from pathlib import Path

import pytest
import yaml

from pipeline.artifacts import (
    State,
    open_run_folder,
    read_run_folder,
)
from pipeline.config import Config
from pipeline.config.file import NOT_COUNTED, config_sha256, dump_config
from pipeline.errors import UsageError
from pipeline.run.stage_specs import SPECS
from tests.artifacts.saved import put


class TestFolder:
    """A run folder changes in one step and loses nothing."""

    def change(self, path: Path, files: dict[str, bytes], superseded: list[str], state: State | None = None) -> None:
        """Change a run folder in one step."""
        with open_run_folder(path) as folder:
            folder.change(state or State(), files, superseded, "name: a\n", {"name": "a"})

    def test_superseded_files_are_kept_with_their_context(self, tmp_path: Path) -> None:
        """Replaced results move to a numbered folder with the configuration and state they belong to."""
        self.change(tmp_path, {"route.csv": b"1", "figures/a.png": b"p"}, [])
        before = (tmp_path / "state.json").read_bytes()
        self.change(tmp_path, {"route.csv": b"2"}, ["route.csv", "figures/a.png"], State(config_sha256="new"))
        old = tmp_path / "superseded" / "0001"
        assert (old / "route.csv").read_bytes() == b"1"
        assert (old / "figures" / "a.png").read_bytes() == b"p"
        assert (old / "state.json").read_bytes() == before
        assert (tmp_path / "route.csv").read_bytes() == b"2"
        assert not (tmp_path / "figures").exists()
        self.change(tmp_path, {"route.csv": b"3"}, ["route.csv"])
        assert (tmp_path / "superseded" / "0002" / "route.csv").read_bytes() == b"2"

    def test_one_run_supersedes_into_one_folder(self, tmp_path: Path) -> None:
        """All that a run replaces is in one place, with the configuration from before the run."""
        self.change(tmp_path, {"route.csv": b"1", "path.csv": b"1"}, [])
        with open_run_folder(tmp_path) as folder:
            folder.change(State(), {}, ["route.csv"], "name: b\n", {})
            folder.change(State(), {}, ["path.csv"], "name: b\n", {})
        old = tmp_path / "superseded" / "0001"
        assert {"route.csv", "path.csv"} <= {path.name for path in old.iterdir()}
        assert (old / "config.yaml").read_text() == "name: a\n"

    def test_unchanged_files_do_not_move(self, tmp_path: Path) -> None:
        """A result that came out the same as before supersedes nothing."""
        self.change(tmp_path, {"route.csv": b"1"}, [])
        self.change(tmp_path, {"route.csv": b"1"}, ["route.csv"])
        assert not (tmp_path / "superseded").exists()
        assert (tmp_path / "route.csv").read_bytes() == b"1"

    def test_failed_writing_changes_nothing(self, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
        """When the disk is full half way, old results, summary and state are all still there."""
        self.change(tmp_path, {"route.csv": b"1"}, [], State(config_sha256="old"))
        before = {path.name: path.read_bytes() for path in tmp_path.iterdir()}
        write = Path.write_bytes

        def full(self: Path, content: bytes) -> int:
            if "summary" in self.name:
                raise OSError(28, "No space left on device", str(self))
            return write(self, content)

        monkeypatch.setattr(Path, "write_bytes", full)
        with pytest.raises(OSError, match="No space left"):
            self.change(tmp_path, {"route.csv": b"2"}, ["route.csv"], State(config_sha256="new"))
        monkeypatch.undo()
        after = {path.name: path.read_bytes() for path in tmp_path.iterdir()}
        assert {**after, ".lock": b""} == {**before, ".lock": b""}

    def test_one_run_at_a_time(self, tmp_path: Path) -> None:
        """A second run into the same folder is refused, and the process of the first is named."""
        with (
            open_run_folder(tmp_path),
            pytest.raises(UsageError, match=f"process {os.getpid()}.*writing to"),
            open_run_folder(tmp_path),
        ):
            pass
        with open_run_folder(tmp_path):
            pass

    def test_lock_of_a_killed_run_does_not_stay(self, tmp_path: Path) -> None:
        """A run that was killed keeps nobody out."""
        script = f"""
            import os, pathlib, signal
            from pipeline.artifacts import open_run_folder
            with open_run_folder(pathlib.Path({str(tmp_path)!r})):
                os.kill(os.getpid(), signal.SIGKILL)
        """
        subprocess.run([sys.executable, "-c", textwrap.dedent(script)], check=False)
        assert (tmp_path / ".lock").read_text() != ""
        with open_run_folder(tmp_path):
            pass

    @pytest.mark.parametrize("name", ["config.yaml", "trajectory.csv", "figures/mine.png"])
    def test_foreign_files_are_not_overwritten(self, tmp_path: Path, name: str) -> None:
        """A folder that is not a run folder but has files of the same names is left alone."""
        put(tmp_path, {name: b"mine"})
        reserved = [pattern for spec in SPECS for pattern in spec.patterns]
        with pytest.raises(UsageError, match=f"already holds {name}"), open_run_folder(tmp_path, reserved):
            pass
        assert [path for path in tmp_path.rglob("*") if path.is_file()] == [tmp_path / name]

    def test_a_file_is_no_folder(self, tmp_path: Path) -> None:
        """A file in place of the folder is refused."""
        (tmp_path / "out").touch()
        with pytest.raises(UsageError, match="is a file"), open_run_folder(tmp_path / "out"):
            pass

    def test_reading_needs_a_run(self, tmp_path: Path, fast_config: Config) -> None:
        """Looking at results needs a run folder whose configuration is that of its results."""
        with pytest.raises(UsageError, match="does not exist"):
            read_run_folder(tmp_path / "none")
        with pytest.raises(UsageError, match="is not a run folder"):
            read_run_folder(tmp_path)
        with open_run_folder(tmp_path) as folder:
            folder.change(State(config_sha256=config_sha256(fast_config)), {}, [], dump_config(fast_config), {})
        assert read_run_folder(tmp_path)[0] == fast_config
        text = (tmp_path / "config.yaml").read_text()
        (tmp_path / "config.yaml").write_text(text.replace("step_budget: 25", "step_budget: 24"))
        with pytest.raises(UsageError, match="was changed after the run"):
            read_run_folder(tmp_path)

    @pytest.mark.parametrize("not_counted", [set(), NOT_COUNTED])
    def test_runs_from_before_a_key_existed_are_read(
        self, tmp_path: Path, fast_config: Config, not_counted: set[str]
    ) -> None:
        """The key has its default; the file is still the one that the run has written."""
        data = fast_config.model_dump(mode="json")
        del data["machine"]["limits"]["holding_fraction"], data["bound"]
        counted = {key: value for key, value in data.items() if key not in not_counted}
        with open_run_folder(tmp_path) as folder:
            folder.change(State(config_sha256=config_sha256(counted)), {}, [], yaml.safe_dump(data), {})
        assert read_run_folder(tmp_path)[0] == fast_config
        counted = {key: value for key, value in data.items() if key not in ("figures", "atlas")}
        with open_run_folder(tmp_path) as folder:
            folder.change(State(config_sha256=config_sha256(counted)), {}, [], yaml.safe_dump(data), {})
        assert read_run_folder(tmp_path)[0] == fast_config
        data["route"]["step_budget"] = 24
        (tmp_path / "config.yaml").write_text(yaml.safe_dump(data))
        with pytest.raises(UsageError, match="was changed after the run"):
            read_run_folder(tmp_path)
