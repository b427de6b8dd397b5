"""Reading and writing configuration files, and saying precisely what is wrong with them."""

import difflib
import hashlib
import json
from pathlib import Path
from typing import Any, get_args

import yaml
from pydantic import BaseModel, ValidationError

from pipeline.config import Config
from pipeline.errors import ConfigError, ConfigIssue


class _UniqueKeyLoader(yaml.SafeLoader):
    """PyYAML's safe loader, but a key given twice is an error rather than silently the last one."""

    def construct_mapping(self, node: yaml.MappingNode, deep: bool = False) -> dict[Any, Any]:
        seen: set[Any] = set()
        for key_node, _ in node.value:
            key = self.construct_object(key_node, deep=True)  # type: ignore[no-untyped-call]  # PyYAML is untyped here
            if isinstance(key, str) and key in seen:
                raise yaml.constructor.ConstructorError(
                    "while reading a section", node.start_mark, f"the key {key!r} is given twice", key_node.start_mark
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
        raise ConfigError([ConfigIssue("(top level)", "must be a mapping with the keys machine, task, route")], source)
    try:
        config = Config.model_validate(data)
    except ValidationError as error:
        raise ConfigError([_explain(item) for item in error.errors()], source) from None
    return config if config.name else config.model_copy(update={"name": default_name})


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
        raise ConfigError([ConfigIssue("(file)", f"cannot be read: {error.strerror}")], str(path)) from None
    except UnicodeDecodeError:
        raise ConfigError([ConfigIssue("(file)", "is not a UTF-8 text file")], str(path)) from None
    try:
        return yaml.load(text, Loader=_UniqueKeyLoader)
    except yaml.MarkedYAMLError as error:
        mark = error.problem_mark
        place = f"line {mark.line + 1}, column {mark.column + 1}" if mark else "(file)"
        raise ConfigError([ConfigIssue(place, f"is not valid YAML: {error.problem}")], str(path)) from None
    except yaml.YAMLError as error:
        raise ConfigError([ConfigIssue("(file)", f"is not valid YAML: {error}")], str(path)) from None


def _explain(item: Any) -> ConfigIssue:
    """Turn one pydantic error into path, value and what is allowed."""
    location, kind, value, context = item["loc"], item["type"], item["input"], item.get("ctx", {})
    path = _key_path(location) or "(top level)"
    if kind == "extra_forbidden":
        return ConfigIssue(path, f"is not a known key; {_known_keys(location)}", value)
    if kind == "missing":
        return ConfigIssue(path, "is missing")
    if kind == "value_error":
        return ConfigIssue(path, str(context["error"]))
    if kind in ("less_than_equal", "greater_than_equal", "less_than", "greater_than"):
        hint = _unit_hint(str(location[-1] if isinstance(location[-1], str) else location[-2]), value, context)
        return ConfigIssue(path, f"is {value!r}; {_lower_first(item['msg']).replace('input', 'it')}{hint}", value)
    if kind == "string_pattern_mismatch" and location[-1] == "mode":
        return ConfigIssue(path, f"is {value!r}; allowed are three letters L or R, one per arm, such as LLL", value)
    return ConfigIssue(path, f"is {_shorten(value)}; {_lower_first(item['msg']).replace('input', 'it')}", value)


def _key_path(location: tuple[int | str, ...]) -> str:
    path = ""
    for part in location:
        path += f"[{part}]" if isinstance(part, int) else f".{part}" if path else part
    return path


def _known_keys(location: tuple[int | str, ...]) -> str:
    """List the keys allowed beside an unknown one, the likeliest first."""
    model: Any = Config
    for part in location[:-1]:
        if isinstance(part, int):
            model = get_args(model)[0]
        else:
            model = model.model_fields[part].annotation
    keys = list(model.model_fields)
    close = difflib.get_close_matches(str(location[-1]), keys, n=1)
    meant = f"did you mean {close[0]!r}? " if close else ""
    return f"{meant}Allowed here: {', '.join(keys)}"


def _unit_hint(key: str, value: object, context: dict[str, Any]) -> str:
    limit = context.get("le", context.get("lt"))
    if limit is None or not isinstance(value, int | float):
        return ""
    if key.endswith("_m") and 1 <= abs(value) / 1000 <= limit:
        return f" (metres are expected: is {value:g} in millimetres?)"
    return f" (the unit is {key.rsplit('_', 1)[-1]})" if "_" in key else ""


def _lower_first(text: str) -> str:
    return text[:1].lower() + text[1:]


def _shorten(value: object) -> str:
    text = repr(value)
    return text if len(text) <= 60 else text[:57] + "..."
