"""The keys of a configuration, as the JSON schema describes them, and the reference configuration with all of them."""

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from from_code.markdown import literal, plain, table
from pipeline.config import Config
from pipeline.config.commented import commented_yaml
from pipeline.config.file import load_config

Schema = Mapping[str, Any]
_REFERENCE_MACHINE = Path(__file__).parents[2] / "configs" / "agder.yaml"
_BOUNDS = (
    ("minimum", "at least"),
    ("exclusiveMinimum", "above"),
    ("maximum", "at most"),
    ("exclusiveMaximum", "below"),
)


def configuration_yaml() -> str:
    """Write the reference configuration with every key, as `gantry-tau check CONFIG --yaml` prints it."""
    return f"```yaml\n{commented_yaml(load_config(_REFERENCE_MACHINE))}```\n"


def configuration_reference() -> str:
    """Write a section with a table of keys for every section of the configuration, nested ones by their dotted path."""
    schema = Config.model_json_schema()
    return "\n".join(_sections(schema, schema["$defs"], "", {}))


def _sections(section: Schema, named: Schema, path: str, described: dict[str, str]) -> Iterator[str]:
    """Describe a section and all within it; those that look alike are described once and referred to."""
    nested: list[tuple[str, str]] = []
    rows = []
    for key, value in section["properties"].items():
        inner = [(f"{path}{key}{suffix}", name) for name, suffix in _references(value)]
        for place, name in inner:
            if name not in described:
                described[name] = place
                nested.append((place, name))
        required = key in section.get("required", ())
        rows.append((literal(key), _kind(value, inner, described), _default(value, required), _meaning(value, named)))
    if path or rows:
        yield table(("key", "value", "default", "meaning"), rows)
    for place, name in nested:
        depth = "##" if "." not in place else "###"
        about = " ".join(named[name].get("description", "").split("\n\n")[0].split())
        if "properties" in named[name]:
            yield f"{depth} {place}\n\n{plain(about)}\n"
            yield from _sections(named[name], named, f"{place}.", described)
        else:
            yield f"{depth} {place}\n\n{plain(about)}\n\nOne of {_choices(named[name])}.\n"


def _references(value: Schema) -> Iterator[tuple[str, str]]:
    """Find the sections that a value may be: their names, and `[]` where the value is a list of them."""
    if "$ref" in value:
        yield value["$ref"].rsplit("/", 1)[-1], ""
    for way in ("anyOf", "oneOf", "allOf"):
        for part in value.get(way, ()):
            yield from _references(part)
    parts = [value["items"]] if "items" in value else value.get("prefixItems", ())[:1]
    for part in parts:
        yield from ((name, f"{suffix}[]") for name, suffix in _references(part))


def _kind(value: Schema, inner: list[tuple[str, str]], described: Mapping[str, str]) -> str:
    """Say what values are: a section and where it is described, choices, or a type with its bounds."""
    links = [f"[{literal(described[name])}](#{_anchor(described[name])})" for _, name in inner]
    plain_kinds = [_type(part) for part in _alternatives(value) if not list(_references(part))]
    return " or ".join([*links, *(kind for kind in plain_kinds if kind)])


def _alternatives(value: Schema) -> list[Schema]:
    parts = [part for way in ("anyOf", "oneOf") for part in value.get(way, ())]
    return [inner for part in parts for inner in _alternatives(part)] if parts else [value]


def _type(value: Schema) -> str:
    if "enum" in value or "const" in value:
        return _choices(value)
    if value.get("type") == "array":
        items = value.get("prefixItems") or [value.get("items", {})]
        count = f"{len(items)} times " if len(items) > 1 else "list of "
        return count + _type(items[0])
    name = {"boolean": "on, off", "number": "number", "integer": "whole number", "string": "text", "null": "null"}
    bounds = [f"{word} {value[bound]:,g}" for bound, word in _BOUNDS if bound in value]
    pattern = [f"like {literal(value['pattern'])}"] if "pattern" in value else []
    return ", ".join([name.get(str(value.get("type")), ""), *bounds, *pattern])


def _choices(value: Schema) -> str:
    return ", ".join(literal(choice) for choice in value.get("enum", [value.get("const")]))


def _default(value: Schema, required: bool) -> str:
    if required:
        return "**required**"
    default = value.get("default", ...)
    if default is ... or isinstance(default, dict) or (isinstance(default, list) and default[:1] and "$ref" in value):
        return ""
    words = {True: "on", False: "off", None: "null"}
    return literal(words[default] if isinstance(default, bool | None) else default if default != "" else "''")


def _meaning(value: Schema, named: Schema) -> str:
    text = value.get("description", "")
    return plain(" ".join(text.split()))


def _anchor(place: str) -> str:
    """The anchor that Markdown gives a heading."""
    return "".join(sign for sign in place.lower() if sign.isalnum() or sign in "-_")
