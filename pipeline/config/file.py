"""Reading and writing configuration files, and saying precisely what is wrong with them."""

import hashlib
import json
import re
from pathlib import Path
from typing import Any

import yaml
from pydantic import BaseModel, ValidationError

from pipeline.config.config import Config
from pipeline.config.messages import explain
from pipeline.errors import ConfigError, ConfigIssue


class _UniqueKeyLoader(yaml.SafeLoader):
    """PyYAML's safe loader, but a key given twice is an error rather than silently the last one."""

    def compose_mapping_node(self, anchor: Any) -> yaml.MappingNode:
        node = super().compose_mapping_node(anchor)
        seen: set[str] = set()
        for key in (key for key, _ in node.value if isinstance(key, yaml.ScalarNode)):
            if key.value in seen:
                problem = f"the key {key.value!r} is given twice"
                raise yaml.composer.ComposerError("while reading a section", node.start_mark, problem, key.start_mark)
            seen.add(key.value)
        return node


def load_config(path: Path | str) -> Config:
    """Read and validate a YAML configuration; the name defaults to the file's.

    Raises
    ------
    ConfigError
        When the file cannot be read or is not a valid configuration; names every offending key.
    """
    path = Path(path)
    return parse_config(read_yaml(path), source=str(path), default_name=path.stem)


def parse_config(data: object, source: str = "configuration", default_name: str = "run") -> Config:
    """Validate a nested dictionary as `load_config` does a file.

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
        config = Config.model_validate(data)
    except ValidationError as error:
        raise ConfigError([explain(item) for item in error.errors()], source) from None
    return config if config.name else config.model_copy(update={"name": _name_from(default_name)})


def dump_config(config: Config) -> str:
    """Write the fully resolved configuration as YAML that `load_config` reads back."""
    return yaml.safe_dump(config.model_dump(mode="json"), sort_keys=False, default_flow_style=None, width=110)


def config_sha256(config: BaseModel | object) -> str:
    """Hash a configuration (or a part of one) by content, independent of formatting and comments."""
    plain = config.model_dump(mode="json") if isinstance(config, BaseModel) else config
    return hashlib.sha256(json.dumps(plain, sort_keys=True).encode()).hexdigest()


def read_yaml(path: Path) -> object:
    """Read a YAML file as it is, without defaults.

    Raises
    ------
    ConfigError
        When the file cannot be read, or is not YAML.
    """
    try:
        text = path.read_text(encoding="utf-8")
    except OSError as error:
        raise _unreadable(path, f"cannot be read: {error.strerror}") from None
    except UnicodeDecodeError:
        raise _unreadable(path, "is not a UTF-8 text file") from None
    try:
        return yaml.load(text, Loader=_UniqueKeyLoader)
    except yaml.MarkedYAMLError as error:
        mark = error.problem_mark or error.context_mark
        place = f"line {mark.line + 1}, column {mark.column + 1}" if mark else "(file)"
        problem = ", ".join(part for part in (error.context, error.problem) if part)
        raise _unreadable(path, f"is not valid YAML: {problem}", place) from None
    except yaml.reader.ReaderError as error:
        place = f"line {text.count(chr(10), 0, error.position) + 1}"
        raise _unreadable(path, "has a control character, which YAML does not allow", place) from None
    except ValueError as error:
        raise _unreadable(path, f"has a value that cannot be read: {error}") from None


def _unreadable(path: Path, message: str, place: str = "(file)") -> ConfigError:
    return ConfigError([ConfigIssue(place, message)], str(path))


def _name_from(text: str) -> str:
    """Make a name that `Config.name` allows: what it does not allow becomes a dash."""
    return re.sub(r"[^\w.-]+", "-", text).lstrip("-.") or "run"
