"""What is wrong with a configuration, in one clear sentence per key: its path, the value, what is allowed there."""

import datetime
import difflib
import functools
import json
import re
from dataclasses import replace
from typing import Any

from pydantic_core import ErrorDetails

from pipeline.config.atlas import STATION_PATTERN
from pipeline.config.config import Config
from pipeline.config.export import JOINT_PATTERN
from pipeline.config.section import MODE_PATTERN, NAME_PATTERN
from pipeline.errors import ConfigIssue

_Schema = dict[str, Any]

_PATTERNS = {
    MODE_PATTERN: "three letters L or R, one per arm, such as LLL",
    JOINT_PATTERN: "letters, digits, '_', '/', '-' and '.', the first a letter or '_'",
    STATION_PATTERN: "letters, digits and '_', in parts joined by '-' or '.'",
    NAME_PATTERN: "letters, digits, '_', '-' and '.', the first a letter, a digit or '_'",
}
_KINDS = {"number": "a number", "integer": "a whole number", "boolean": "on or off, without quotes", "null": "null"}
_SHOWN = 60
"""Longest key or value in a message."""
_UNITS = {
    "m": ("metres", "millimetres"),
    "s": ("seconds", "milliseconds"),
    "mps": ("metres per second", "millimetres per second"),
    "mps2": ("metres per second squared", "millimetres per second squared"),
    "mps3": ("metres per second cubed", "millimetres per second cubed"),
}


def explain(error: ErrorDetails) -> ConfigIssue:
    """Turn one error of pydantic's into a key's path, the value found there and what is allowed."""
    location, kind, value = error["loc"], error["type"], error["input"]
    keys = _without_choices(location)
    path = key_path(keys)
    if kind == "rule" and "key" not in error.get("ctx", {}):
        return ConfigIssue(path, error["msg"], value)
    if kind == "rule":
        return ConfigIssue(key_path((*keys, error["ctx"]["key"])), error["ctx"]["message"], value)
    if kind in ("extra_forbidden", "invalid_key"):
        return ConfigIssue(path, f"is not a known key{_known_keys(location)}", value)
    schema = _allowing(location)
    if kind == "missing":
        return ConfigIssue(path, f"is missing; allowed is {_allowed(schema)}")
    if kind == "too_long" and isinstance(value, list) and "items" in _given(schema):
        return ConfigIssue(path, f"has {len(value):,} entries; allowed are at most {_given(schema)['maxItems']}", value)
    if kind == "truth_value" and isinstance(value, list):
        # The one entry of the list that is at fault, if the list has so many.
        entry = next(k for k, item in enumerate(value) if isinstance(item, bool))
        if entry < len(_given(schema).get("prefixItems", ())):
            return _refused((*location, entry), value[entry])
    return _refused(location, value)


def named(issue: ConfigIssue, location: tuple[int | str, ...], data: object) -> ConfigIssue:
    """Add to an issue the name of the entry of a list that it is in, if that has one: `machine.bodies[8]` is a body."""
    name: object = ""
    for part in location:
        if isinstance(data, dict):
            data = data.get(part)
        elif isinstance(data, list) and isinstance(part, int) and part < len(data):
            data = data[part]
            name = data.get("name", "") if isinstance(data, dict) else ""
        else:
            break
    if not isinstance(name, str) or not name or location[-1:] == ("name",):
        return issue
    return replace(issue, message=f"{issue.message} (of {_shown(name)})")


def _refused(location: tuple[int | str, ...], value: object) -> ConfigIssue:
    """Say what is found at a key, and what is allowed there."""
    path, schema = key_path(_without_choices(location)), _allowing(location)
    hint = _unit_hint(location, value, _given(schema)) or _quotes_hint(value, schema)
    return ConfigIssue(path, f"is {_shown(value)}; allowed is {_allowed(schema)}{hint}", value)


def key_path(location: tuple[int | str, ...]) -> str:
    """Write a location as a path: task.start.x_m, machine.rails[0]."""
    path = ""
    for part in location:
        path += f"[{part}]" if isinstance(part, int) else f".{_cut(part)}" if path else _cut(part)
    return path or "(top level)"


def _allowing(location: tuple[int | str, ...]) -> _Schema:
    """Find what is allowed at a location: where one of several kinds of values is wrong, all of them."""
    return _schema_at(location[:-1] if location and _is_choice(location[:-1]) else location)


def _without_choices(location: tuple[int | str, ...]) -> tuple[int | str, ...]:
    """Leave out of a location what only names one of several kinds of values of a key."""
    return tuple(part for k, part in enumerate(location) if not _is_choice(location[:k]))


def _is_choice(location: tuple[int | str, ...]) -> bool:
    """Check whether the part after a location names a kind of value, rather than a key."""
    return "oneOf" in _given(_schema_at(location))


def _schema_at(location: tuple[int | str, ...]) -> _Schema:
    """Find the JSON schema of a key by its location."""
    schema = _whole_schema()
    for part in location:
        schema = _given(schema)
        if "oneOf" in schema:
            schema = next(choice for choice in schema["oneOf"] if part in (choice.get("type"), _referred(choice)))
        elif isinstance(part, str):
            schema = schema["properties"][part]
        else:
            schema = schema["prefixItems"][part] if "prefixItems" in schema else schema["items"]
    return _resolved(schema)


@functools.cache
def _whole_schema() -> _Schema:
    return Config.model_json_schema()


def _given(schema: _Schema) -> _Schema:
    """Find what has parts: of a key that may be null the other choice."""
    return _resolved(next((choice for choice in schema.get("anyOf", []) if choice.get("type") != "null"), schema))


def _resolved(schema: _Schema) -> _Schema:
    """Look up what a reference refers to."""
    definitions: _Schema = _whole_schema()["$defs"]
    return definitions[_referred(schema)] if "$ref" in schema else schema


def _referred(schema: _Schema) -> str:
    return str(schema.get("$ref", "")).rsplit("/", 1)[-1]


def _allowed(schema: _Schema) -> str:
    """Say what a schema allows."""
    schema = _resolved(schema)
    if choices := schema.get("anyOf", schema.get("oneOf")):
        return " or ".join(_allowed(choice) for choice in choices)
    if "enum" in schema:
        return " or ".join(schema["enum"])
    if "pattern" in schema:
        most = f", at most {schema['maxLength']} of them" if "maxLength" in schema else ""
        return _PATTERNS[schema["pattern"]] + most
    if schema["type"] == "array":
        return _allowed_list(schema)
    if schema["type"] == "object":
        return f"a section with the keys {', '.join(schema['properties'])}"
    return _KINDS[schema["type"]] + _range(schema)


def _allowed_list(schema: _Schema) -> str:
    if "prefixItems" not in schema:
        return f"a list of {_allowed(schema['items'])}"
    length, item = schema["minItems"], schema["prefixItems"][0]
    kind = "sections" if "$ref" in item else f"words ({_allowed(item)})" if "pattern" in item else ""
    return f"a list of {length} {kind or f'numbers{_range(item)}'}"


def _range(schema: _Schema) -> str:
    low = f" from {schema['minimum']:g}" if "minimum" in schema else ""
    above = f" above {schema['exclusiveMinimum']:g}" if "exclusiveMinimum" in schema else ""
    most = ", at most" if above else " to"
    high = f"{most} {schema['maximum']:g}" if "maximum" in schema else ""
    if "exclusiveMaximum" in schema:
        high = f"{',' if above else ' to' if low else ''} less than {schema['exclusiveMaximum']:g}"
    return low + above + high


def _known_keys(location: tuple[int | str, ...]) -> str:
    """List the keys allowed beside an unknown one, the likeliest first."""
    keys = list(_given(_schema_at(location[:-1]))["properties"])
    close = difflib.get_close_matches(str(location[-1])[:_SHOWN], keys, n=1)
    meant = f" (did you mean {close[0]}?)" if close else ""
    return f"{meant}; allowed here are {', '.join(keys)}"


def _unit_hint(location: tuple[int | str, ...], value: object, schema: _Schema) -> str:
    """Guess that a value too large by a factor of a thousand was given in the wrong unit."""
    if not isinstance(value, int | float) or not abs(value) > schema.get("maximum", abs(value)):
        return ""
    names = [re.search(r"_(m|s|mps|mps2|mps3)$", str(part)) for part in location]
    units = [_UNITS[match[1]] for match in names if match]
    if not units or abs(value) > 1000.0 * schema["maximum"]:
        return ""
    unit, smaller = units[-1]
    return f" (the unit is {unit}: is {_shown(value)} in {smaller}?)"


def _quotes_hint(value: object, schema: _Schema) -> str:
    """Explain that YAML took a word for something else."""
    if "string" not in _types(schema):
        return ""
    if isinstance(value, bool):
        return " (YAML reads on, off, yes, no, true and false as truth values: if a word is meant, put it in quotes)"
    if isinstance(value, int | float | datetime.date):
        return " (YAML does not read this as a word: put it in quotes)"
    return ""


def _types(schema: _Schema) -> set[str]:
    """List the JSON types that a schema allows."""
    choices = [_resolved(choice) for choice in schema.get("anyOf", [schema])]
    return {choice["type"] for choice in choices if "type" in choice}


def _shown(value: object) -> str:
    try:
        text = json.dumps(value, default=str, ensure_ascii=False)
    except (TypeError, ValueError, RecursionError):
        return f"a value that cannot be shown ({type(value).__name__})"
    return _cut(text)


def _cut(text: str) -> str:
    return text if len(text) <= _SHOWN else f"{text[: _SHOWN - 3]}..."
