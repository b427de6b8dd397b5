"""Configuration in README and documentation: YAML that is read, and names of keys that exist."""

import re
from pathlib import Path
from typing import Any

import pytest
import yaml

from pipeline.config import Config
from pipeline.config.file import parse_config
from pipeline.study.config import parse_study
from tests.docs.pages import PAGES, blocks, inline_code, page_name

_SECTIONS = tuple(name for name in Config.model_fields if name != "name")
_KEY = re.compile(rf"(?:{'|'.join(_SECTIONS)})(?:\.[a-z0-9_]+)+")
_ELSEWHERE = re.compile(r"(route|path|trajectory|certificate|atlas)\.(csv|npz|json|png|\w+_bound.*)|export\.\w+\.py")
IN_THE_SUMMARY = {
    "path.quality",
    "route.steps",
    "route.objective_kind",
    "trajectory.usage",
    "trajectory.status",
}
"""Names of figures in `summary.json`, whose sections have the names of stages, too."""


def keys(schema: dict[str, Any], named: dict[str, Any], path: str = "") -> set[str]:
    """Collect the dotted keys of a schema, whatever alternatives a section has; `[]` is left out."""
    found: set[str] = set()
    if "$ref" in schema:
        return keys(named[schema["$ref"].rsplit("/", 1)[-1]], named, path)
    for key, value in schema.get("properties", {}).items():
        place = f"{path}.{key}".strip(".")
        found |= {place} | keys(value, named, place)
    parts = [part for way in ("anyOf", "oneOf", "allOf", "prefixItems") for part in schema.get(way, [])]
    for part in [*parts, *([schema["items"]] if "items" in schema else [])]:
        found |= keys(part, named, path)
    return found


def merged(data: Any, changes: Any) -> Any:
    """Put changes into nested dictionaries; a section with other keys altogether is another one in its place."""
    if not (isinstance(data, dict) and isinstance(changes, dict) and data.keys() & changes.keys()):
        return changes
    return {**data, **{key: merged(data.get(key), value) for key, value in changes.items()}}


@pytest.mark.parametrize("page", PAGES, ids=page_name)
def test_yaml_is_configuration(page: Path, quick_config: Config) -> None:
    """Every YAML block is a part of a configuration that the program reads, or the file of a study."""
    for code in blocks(page, "yaml"):
        if "base" in yaml.safe_load(code):
            parse_study(yaml.safe_load(code))
            continue
        parse_config(merged(quick_config.model_dump(mode="json"), yaml.safe_load(code)))


@pytest.mark.parametrize("page", PAGES, ids=page_name)
def test_keys_exist(page: Path) -> None:
    """Every key that is named with its section is in the schema."""
    schema = Config.model_json_schema()
    known = keys(schema, schema["$defs"]) | IN_THE_SUMMARY
    named = {match[0] for code in inline_code(page) if (match := _KEY.match(code))}
    assert {key for key in named if not _ELSEWHERE.match(key)} <= known
