"""A configuration as YAML with every key and what it means, as the schema describes it."""

import itertools
import textwrap
from collections.abc import Iterator

import yaml
from pydantic import BaseModel

from pipeline.config.config import Config
from pipeline.config.section import Section

_COLUMN, _WIDTH = 40, 118
"""Where comments begin, and where lines end."""


def commented_yaml(config: Config) -> str:
    """Write every key with its value, defaults included, and its description as a comment; `load_config` reads it."""
    parts = ["\n".join(entry) + "\n" for entry in _entries(config, 0)]
    return "\n".join(parts)


def commented_file(config: Config, *heading: str) -> str:
    """Write a file to make one's own from: the lines of the heading as they are, then `commented_yaml`."""
    lines = (
        *heading,
        "# Lengths in metres, tilts in degrees. A key that is left out has its default, if it has one.",
        "# `gantry-tau check` with this file shows the machine at start and goal; `gantry-tau run` plans.",
        "",
        commented_yaml(config),
    )
    return "\n".join(lines)


def _entries(section: BaseModel, indent: int) -> Iterator[list[str]]:
    """Write the lines of every key; a description is not repeated for the next key."""
    said = ""
    for name, field in type(section).model_fields.items():
        value = getattr(section, name)
        description = field.description or _first_sentence(value)
        yield list(_entry(name, value, "" if description == said else description, indent))
        said = description


def _entry(name: str, value: object, description: str, indent: int) -> Iterator[str]:
    pad = " " * indent
    if isinstance(value, BaseModel):
        if isinstance(value, Section) and value.on_one_line:
            yield from _commented(f"{pad}{name}: {_inline(value)}", description, indent)
        else:
            yield from _commented(f"{pad}{name}:", description, indent)
            yield from itertools.chain.from_iterable(_entries(value, indent + 2))
    elif isinstance(value, tuple) and any(isinstance(item, BaseModel) for item in value):
        yield from _commented(f"{pad}{name}:", description, indent)
        yield from (f"{pad}  - {_inline(item)}" for item in value)
    else:
        yield from _commented(f"{pad}{name}: {_inline(value)}", description, indent)


def _commented(text: str, description: str, indent: int) -> Iterator[str]:
    """Put the comment behind the text, or above it where it does not fit."""
    if not description:
        yield text
        return
    column = max(_COLUMN, len(text) + 2)
    if column + 2 + len(description) <= _WIDTH:
        yield f"{text.ljust(column)}# {description}"
        return
    start = " " * indent + "# "
    yield from textwrap.wrap(description, _WIDTH, initial_indent=start, subsequent_indent=start)
    yield text


def _first_sentence(section: object) -> str:
    """Take the description of a section without one of its own from its class."""
    if not isinstance(section, BaseModel):
        return ""
    text = " ".join((type(section).__doc__ or "").split("\n\n")[0].split()).rstrip(".")
    return text[:1].lower() + text[1:]


def _inline(value: object) -> str:
    if isinstance(value, bool):
        return "on" if value else "off"
    data = value.model_dump(mode="json") if isinstance(value, BaseModel) else value
    plain = yaml.safe_dump(_plain(data), default_flow_style=True, sort_keys=False, width=10_000)
    return plain.removesuffix("\n").removesuffix("\n...")


def _plain(data: object) -> object:
    if isinstance(data, dict):
        return {key: _plain(item) for key, item in data.items()}
    if isinstance(data, tuple | list):
        return [_plain(item) for item in data]
    return str(data) if isinstance(data, str) else data
