"""Reading and writing configuration files, and saying precisely what is wrong with them."""

import hashlib
import json
import os
import re
from collections.abc import Callable
from pathlib import Path

import yaml
from pydantic import BaseModel, ValidationError

from pipeline.config.config import Config
from pipeline.config.messages import explain, named
from pipeline.config.section import MOST_NAME
from pipeline.errors import ConfigError, ConfigIssue
from pipeline.regular_file import read_named_file
from pipeline.yaml_text import MOST_BYTES, YamlError, parse_yaml

Read = Callable[[Path, int], bytes]
"""Reads a file of at most so many bytes."""


_RESULTS = Path("results")
_IN_RUN_FOLDERS = "config.yaml"
_MOST_ISSUES = 100
"""Faults that are explained: a file of another kind has thousands."""


def load_config(path: Path | str, read: Read = read_named_file) -> Config:
    """Read and validate a YAML configuration; the name defaults to the file's.

    Parameters
    ----------
    read : callable
        Reads a file of at most so many bytes; by default it may be a pipe or a device, too.

    Raises
    ------
    ConfigError
        When the file cannot be read or is not a valid configuration; names every offending key.
    """
    path = Path(path)
    return parse_config(read_yaml(path, read), source=str(path), default_name=path.stem, folder=path.parent)


def parse_config(
    data: object, source: str = "configuration", default_name: str = "run", folder: Path = Path()
) -> Config:
    """Validate a nested dictionary as `load_config` does a file; meshes are looked for in `folder`.

    Raises
    ------
    ConfigError
        When it is not a valid configuration; names every offending key.
    """
    if not isinstance(data, dict):
        raise ConfigError(
            [ConfigIssue("(top level)", "must be a section with the keys machine, task and route")], source
        )
    try:
        config = Config.model_validate(data, context={"folder": folder})
    except ValidationError as error:
        raise ConfigError(_issues(error, data), source) from None
    return config if config.name else config.model_copy(update={"name": _name_from(default_name)})


def dump_config(config: Config) -> str:
    """Write the fully resolved configuration as YAML that `load_config` reads back."""
    return yaml.safe_dump(config.model_dump(mode="json"), sort_keys=False, default_flow_style=None, width=110)


def schema_text() -> str:
    """Write the JSON schema of a configuration, with which editors complete one."""
    return json.dumps(Config.model_json_schema(), indent=2)


def results_folder(name: str) -> Path:
    """Give the folder of a run or study of a name that is given none, in UTF-8 whatever the locale."""
    return _RESULTS / os.fsdecode(name.encode())


NOT_COUNTED = frozenset({"figures", "atlas", "bound"})
"""Sections that do not count in the hash of a whole configuration."""


def config_sha256(config: BaseModel | object) -> str:
    """Hash a configuration (or a part of one) by content, independent of formatting and comments.

    Of a whole one, how results are drawn does not count, nor do the stations of an atlas and how many boxes bound other
    paths: results are the same.
    """
    not_counted = NOT_COUNTED if isinstance(config, Config) else frozenset[str]()
    plain = config.model_dump(mode="json", exclude=set(not_counted)) if isinstance(config, BaseModel) else config
    return hashlib.sha256(json.dumps(plain, sort_keys=True).encode()).hexdigest()


def read_yaml(path: Path, read: Read = read_named_file) -> object:
    """Read a YAML file as it is, without defaults.

    Raises
    ------
    ConfigError
        When the file cannot be read, is too large, or is not YAML.
    """
    try:
        return parse_yaml(read(path, MOST_BYTES).decode())
    except OSError as error:
        inside = path / _IN_RUN_FOLDERS
        hint = (
            f"; the configuration in it is {inside}; add --out {path} to run stages there" if inside.is_file() else ""
        )
        raise _unreadable(path, f"cannot be read: {error.strerror}{hint}") from None
    except UnicodeDecodeError:
        raise _unreadable(path, "is not a UTF-8 text file") from None
    except YamlError as error:
        raise _unreadable(path, error.message, error.place) from None


def _issues(error: ValidationError, data: object) -> list[ConfigIssue]:
    """Explain the first faults, with the names of the entries of lists they are in, and count the others."""
    found = error.errors(include_url=False)
    more = len(found) - _MOST_ISSUES
    rest = [ConfigIssue("", f"has {more:,} more faults")] if more > 0 else []
    return [*(named(explain(item), item["loc"], data) for item in found[:_MOST_ISSUES]), *rest]


def _unreadable(path: Path, message: str, place: str = "") -> ConfigError:
    return ConfigError([ConfigIssue(place, message)], str(path))


def _name_from(text: str) -> str:
    """Make a name that `Config.name` allows: what it does not allow becomes a dash."""
    return re.sub(r"[^\w.-]+", "-", text).lstrip("-.")[:MOST_NAME] or "run"
