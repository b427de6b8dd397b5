"""Reading YAML in bounded time and memory: nesting, values and aliases are counted before anything is built."""

from typing import Any

import yaml
from yaml.composer import ComposerError

from pipeline.errors import PipelineError

MOST_BYTES = 1_000_000
"""Largest file that is read."""
MOST_VALUES = 50_000
"""Most keys and values, those behind aliases counted wherever they are used."""
MOST_LEVELS = 32
"""Deepest nesting of lists and sections."""
_MOST_DIGITS = 100
_TAG = "tag:yaml.org,2002:"
_NUMBERS = (f"{_TAG}int", f"{_TAG}float")
_KEYS = (f"{_TAG}str", f"{_TAG}merge", f"{_TAG}value")
_READ_AS = {
    f"{_TAG}bool": "a truth value",
    f"{_TAG}int": "a number",
    f"{_TAG}float": "a number",
    f"{_TAG}timestamp": "a date",
    f"{_TAG}null": "nothing",
}
_SHOWN = 40


class YamlError(PipelineError):
    """Text that is not YAML, or not within the bounds: where and what."""

    def __init__(self, place: str, message: str) -> None:
        self.place = place
        self.message = message
        super().__init__(f"{place}: {message}")


def parse_yaml(text: str) -> object:
    """Read YAML text, as PyYAML's safe loader does, but within bounds and without keys given twice.

    Raises
    ------
    YamlError
        When it is not YAML, or has more values or levels than are read.
    """
    try:
        return yaml.load(text, Loader=_BoundedLoader)
    except yaml.MarkedYAMLError as error:
        mark = error.problem_mark or error.context_mark
        problem = ", ".join(part for part in (error.context, error.problem) if part)
        raise _error(mark, f"is not valid YAML: {problem}") from None
    except yaml.reader.ReaderError as error:
        place = f"line {text.count(chr(10), 0, error.position) + 1}"
        raise YamlError(place, "has a control character, which YAML does not allow") from None


class _BoundedLoader(yaml.SafeLoader):
    """PyYAML's safe loader within bounds: what is too much, or given twice, is an error while it is read."""

    def __init__(self, stream: str) -> None:
        super().__init__(stream)
        self._count = 0
        self._level = 0
        self._sizes: dict[str | None, int] = {}

    def compose_node(self, parent: Any, index: Any) -> Any:
        event: Any = self.peek_event()  # type: ignore[no-untyped-call]  # PyYAML's own is not annotated
        before = self._count
        if isinstance(event, yaml.AliasEvent):
            if event.anchor in self.anchors and event.anchor not in self._sizes:
                raise _error(event.start_mark, f"cannot be read: *{_cut(str(event.anchor))} is a part of itself")
            self._grow(self._sizes.get(event.anchor, 0), event)
            return super().compose_node(parent, index)
        self._grow(1, event)
        self._level += 1
        if self._level > MOST_LEVELS:
            problem = f"cannot be read: lists and sections are nested more than {MOST_LEVELS} deep"
            raise _error(event.start_mark, problem)
        node = super().compose_node(parent, index)
        self._level -= 1
        if event.anchor is not None:
            self._sizes[event.anchor] = self._count - before
        return node

    def _grow(self, by: int, event: yaml.NodeEvent) -> None:
        self._count += by
        if self._count > MOST_VALUES:
            problem = f"cannot be read: there are more than {MOST_VALUES:,} keys and values, aliases counted"
            raise _error(event.start_mark, problem)

    def compose_mapping_node(self, anchor: Any) -> yaml.MappingNode:
        node = super().compose_mapping_node(anchor)
        seen: set[str] = set()
        for key, _ in node.value:
            if problem := _wrong_key(key):
                raise _error(key.start_mark, f"cannot be read: {problem}")
            if key.value in seen:
                problem = f"the key {_shown(key)} is given twice"
                raise ComposerError("while reading a section", node.start_mark, problem, key.start_mark)
            seen.add(key.value)
        return node

    def construct_object(self, node: yaml.Node, deep: bool = False) -> Any:
        kind = node.tag.removeprefix(_TAG)
        if node.tag in _NUMBERS and len(node.value) > _MOST_DIGITS:
            problem = f"cannot be read: a number of {len(node.value):,} characters; allowed are {_MOST_DIGITS}"
            raise _error(node.start_mark, problem)
        try:
            return super().construct_object(node, deep)
        # What PyYAML lets through where a text is no value of its kind: it computes with what is not there.
        except (ValueError, LookupError, AttributeError, TypeError, ArithmeticError) as error:
            why = str(error) if kind == "timestamp" and isinstance(error, ValueError) else ""
            problem = f"cannot be read: {_shown(node)} is not a value of the type {kind}{why and f' ({why})'}"
            raise _error(node.start_mark, problem) from None


def _wrong_key(key: yaml.Node) -> str:
    """Say what is wrong with a key; nothing if it is a word."""
    if not isinstance(key, yaml.ScalarNode):
        return "a list or section cannot be a key"
    if key.tag in _KEYS:
        return ""
    read_as = _READ_AS.get(key.tag, key.tag)
    comma = "; a decimal comma? write 1.15" if key.value.isdecimal() else ""
    return f"YAML reads the key {_shown(key)} as {read_as}; if it is meant as a word, put it in quotes{comma}"


def _shown(node: yaml.Node) -> str:
    if not isinstance(node, yaml.ScalarNode):
        return "a list or section"
    return repr(_cut(node.value))


def _cut(text: str) -> str:
    return text if len(text) <= _SHOWN else f"{text[: _SHOWN - 3]}..."


def _error(mark: Any, message: str) -> YamlError:
    return YamlError(f"line {mark.line + 1}, column {mark.column + 1}" if mark else "", message)
