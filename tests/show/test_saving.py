"""The saved file: complete, commented, accepted by `check`, and never written over something unasked."""

import json
from pathlib import Path

import pytest

from pipeline.config import Config
from pipeline.config.file import dump_config, load_config
from pipeline.errors import UsageError
from pipeline.show.saving import is_saved, save_config
from pipeline.summary.versions import versions


def test_what_is_saved_is_read_back(quick_config: Config, tmp_path: Path) -> None:
    """The file holds the configuration under its own name, with the meaning of every key."""
    path = tmp_path / "new" / "left cell.yaml"
    named = save_config(quick_config, path)
    assert load_config(path) == named
    assert named == quick_config.model_copy(update={"name": "left-cell"})
    assert "# Saved by gantry-tau show." in path.read_text()
    assert "# largest |rx| and |rz| anywhere" in path.read_text()
    assert is_saved(quick_config, path)


def test_nothing_is_overwritten_unasked(quick_config: Config, tmp_path: Path) -> None:
    """A file that is there stays as it is, until it is to be replaced."""
    path = tmp_path / "mine.yaml"
    path.write_text("mine")
    with pytest.raises(UsageError, match="is there already"):
        save_config(quick_config, path)
    assert path.read_text() == "mine"
    assert not is_saved(quick_config, path)
    assert save_config(quick_config, path, replace=True) == load_config(path)
    assert is_saved(quick_config, path)


def test_a_run_keeps_its_configuration(quick_config: Config, tmp_path: Path) -> None:
    """Nothing is saved into the folder of a run, even to be replaced: its results would not belong to it any more."""
    (tmp_path / "summary.json").write_text(json.dumps({"versions": versions(), "config_sha256": "of it"}))
    (tmp_path / "config.yaml").write_text(dump_config(quick_config))
    with pytest.raises(UsageError, match="in the folder of a run"):
        save_config(quick_config, tmp_path / "config.yaml", replace=True)
    assert is_saved(quick_config, tmp_path / "config.yaml")


def test_other_files_are_no_configurations(quick_config: Config, tmp_path: Path) -> None:
    """The name has to be that of a YAML file."""
    with pytest.raises(UsageError, match=r"ends in \.yaml"):
        save_config(quick_config, tmp_path / "mine.txt")
    assert list(tmp_path.iterdir()) == []
