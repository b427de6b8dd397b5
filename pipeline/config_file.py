"""Reading and writing configuration files, and saying precisely what is wrong with them."""

import hashlib
import json
import re
from pathlib import Path
from typing import Any

import yaml
from pydantic import BaseModel, ValidationError

from pipeline.config import Config
from pipeline.config_messages import explain
from pipeline.errors import ConfigError, ConfigIssue


class _UniqueKeyLoader(yaml.SafeLoader):
    """PyYAML's safe loader, but a key given twice is an error rather than silently the last one."""

    def construct_mapping(self, node: yaml.MappingNode, deep: bool = False) -> dict[Any, Any]:
        seen: set[Any] = set()
        for key_node, _ in node.value:
            key = self.construct_object(key_node, deep=True)
            if isinstance(key, str) and key in seen:
                raise yaml.constructor.ConstructorError(
                    "while reading a section",
                    node.start_mark,
                    f"the key {key!r} is given twice",
                    key_node.start_mark,
                )
            if isinstance(key, str):
                seen.add(key)
        return super().construct_mapping(node, deep)


def load_config(path: Path | str) -> Config:
    """Read and validate a YAML configuration; the name defaults to the file's.

    Raises
    ------
    ConfigError
        When the file cannot be read or is not a valid configuration; names every offending key.
    """
    path = Path(path)
    return parse_config(_read_yaml(path), source=str(path), default_name=path.stem)


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


def _read_yaml(path: Path) -> object:
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
