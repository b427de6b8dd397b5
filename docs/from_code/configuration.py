"""The keys of a configuration, as the JSON schema describes them, and the reference configuration with all of them."""

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from from_code.markdown import literal, plain, table
from pipeline.config import Config
from pipeline.config.commented import commented_yaml
from pipeline.config.file import load_config
from pipeline.study.config import StudyConfig

Schema = Mapping[str, Any]
_NAMES = {
    "boolean": "on, off",
    "number": "number",
    "integer": "whole number",
    "string": "text",
    "null": "null",
    "object": "key paths with values",
}
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
    return "\n".join(_tables(schema, schema["$defs"], "", {}))


def study_reference() -> str:
    """Write a section with a table of keys for every section of the file of a study."""
    schema = StudyConfig.model_json_schema()
    return "\n".join(_tables(schema, schema["$defs"], "", {}))


def _tables(section: Schema, named: Schema, path: str, titles: dict[str, str]) -> Iterator[str]:
    """Describe a section and all within it; those that look alike are described once and referred to by their title."""
    new: list[tuple[str, str]] = []
    rows = []
    for key, value in section["properties"].items():
        inner = list(_sections(value, named))
        for name, suffix in inner:
            place = f"{path}{key}{suffix}"
            if name not in titles:
                titles[name] = _title(place, named[name], titles)
                new.append((place, name))
        required = key in section.get("required", ())
        about = value.get("description") or (_about(named[inner[0][0]]) if inner else "")
        rows.append((literal(key), _kind(value, named, titles), _default(value, required), plain(about)))
    yield table(("key", "value", "default", "meaning"), rows)
    for place, name in new:
        depth = "##" if "." not in place else "###"
        yield f"{depth} {titles[name]}\n\n{plain(_about(named[name]))}\n"
        yield from _tables(named[name], named, f"{place}.", titles)


def _title(place: str, section: Schema, titles: Mapping[str, str]) -> str:
    """Name a section by its place; where another one may stand there, too, by its keys as well."""
    return place if place not in titles.values() else f"{place} with {', '.join(section['properties'])}"


def _about(section: Schema) -> str:
    """Give the first sentence that is said of a section."""
    return " ".join(section.get("description", "").split("\n\n")[0].split())


def _sections(value: Schema, named: Schema) -> Iterator[tuple[str, str]]:
    """Find the sections that a value may be: their names, and `[]` where the value is a list of them."""
    if (name := _name(value)) and "properties" in named[name]:
        yield name, ""
    for part in _alternatives(value) if _alternatives(value) != [value] else []:
        yield from _sections(part, named)
    parts = [value["items"]] if "items" in value else value.get("prefixItems", ())[:1]
    for part in parts:
        yield from ((name, f"{suffix}[]") for name, suffix in _sections(part, named))


def _name(value: Schema) -> str:
    """Give the name of the definition that a value refers to; empty if it has its own."""
    return str(value.get("$ref", "")).rsplit("/", 1)[-1]


def _alternatives(value: Schema) -> list[Schema]:
    parts = [part for way in ("anyOf", "oneOf") for part in value.get(way, ())]
    return [inner for part in parts for inner in _alternatives(part)] if parts else [value]


def _kind(value: Schema, named: Schema, titles: Mapping[str, str]) -> str:
    """Say what values are: a section and where it is described, choices, or a type with its bounds."""
    return " or ".join(_type(part, named, titles) for part in _alternatives(value))


def _type(value: Schema, named: Schema, titles: Mapping[str, str]) -> str:
    if (name := _name(value)) in titles:
        return f"[{literal(titles[name])}](#{_anchor(titles[name])})"
    if name:
        return _type(named[name], named, titles)
    if "enum" in value or "const" in value:
        return _choices(value)
    if value.get("type") == "array":
        items = value.get("prefixItems") or [value.get("items", {})]
        count = f"{len(items)} times " if len(items) > 1 else "list of "
        return count + _kind(items[0], named, titles)
    if "type" not in value:
        return "any value"
    bounds = [f"{word} {value[bound]:,g}" for bound, word in _BOUNDS if bound in value]
    pattern = [f"like {literal(value['pattern'])}"] if "pattern" in value else []
    return ", ".join([_NAMES[value["type"]], *bounds, *pattern])


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


def _anchor(place: str) -> str:
    """The anchor that Markdown gives a heading."""
    return "".join(sign for sign in place.lower().replace(" ", "-") if sign.isalnum() or sign in "-_")
