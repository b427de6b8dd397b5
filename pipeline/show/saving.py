"""The configuration of the page as a file."""

from pathlib import Path

from pipeline.artifacts.files import write_new, write_whole
from pipeline.artifacts.state import is_of_a_run
from pipeline.config import Config
from pipeline.config.commented import commented_file
from pipeline.config.file import load_config
from pipeline.config.packaged import renamed
from pipeline.errors import ConfigError, UsageError

_ENDINGS = (".yaml", ".yml")


def save_config(config: Config, path: Path, replace: bool = False) -> Config:
    """Write a configuration with every key and its meaning, named like its file; return it as it is there.

    Raises
    ------
    UsageError
        When the name does not end in .yaml, the file is there and not to be replaced, or its folder is that of a run.
    OSError
        When it cannot be written; names the file.
    """
    if path.suffix.lower() not in _ENDINGS:
        raise UsageError(f"{path}: the name of a configuration ends in .yaml")
    if is_of_a_run(path.parent):
        raise UsageError(f"{path} is in the folder of a run, whose files are not overwritten: give another name")
    named = renamed(config, path.stem)
    content = commented_file(named, "# Saved by gantry-tau show.").encode()
    if replace and path.exists():
        write_whole(path, content)
        return named
    try:
        write_new(path, content)
    except FileExistsError:
        raise UsageError(f"{path} is there already: give another name, or tick 'replace the file'") from None
    return named


def is_saved(config: Config, path: Path) -> bool:
    """Check whether a file holds this configuration, whatever its name."""
    try:
        return renamed(load_config(path), config.name) == renamed(config, config.name)
    except ConfigError:
        return False
