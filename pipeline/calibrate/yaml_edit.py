"""Values put into a YAML text where they belong, all else left as it is: comments, order, spelling of numbers."""

from collections.abc import Iterator, Mapping
from itertools import pairwise
from typing import Any, NamedTuple

import yaml

Tree = Mapping[str | int, Any]
"""New values by key, or by index in a list; a mapping is a section of which only these keys change."""
_WIDTH = 10_000


class _Edit(NamedTuple):
    start: int
    end: int
    text: str


def with_values(text: str, values: Tree) -> str:
    """Replace values, and add those of keys that are not there; sections that are not there are added on one line.

    Raises
    ------
    ValueError
        When the text has no section at its top, something else where a section is to be, or one part in several places.
    """
    edits = sorted(set(_edits(yaml.compose(text, Loader=yaml.SafeLoader), values, text)), reverse=True)
    if any(earlier.end > later.start for later, earlier in pairwise(edits)):
        raise ValueError("a part of the file is used in several places (by an anchor, & and *)")
    for start, end, new in edits:
        text = text[:start] + new + text[end:]
    return text


def _edits(node: Any, values: Tree, text: str) -> Iterator[_Edit]:
    if isinstance(node, yaml.SequenceNode):
        for index, value in values.items():
            yield from _edit_of(node.value[int(index)], value, text)
        return
    if not isinstance(node, yaml.MappingNode):
        raise ValueError("expected a section")  # noqa: TRY004  # of the text, not of the program
    there = {key.value: value for key, value in node.value}
    new = {key: value for key, value in values.items() if key not in there}
    for key, value in values.items():
        if key in there:
            yield from _edit_of(there[key], value, text)
    if new:
        yield _addition(node, new, text)


def _edit_of(node: Any, value: Any, text: str) -> Iterator[_Edit]:
    if isinstance(value, Mapping):
        yield from _edits(node, value, text)
    elif isinstance(value, list) and isinstance(node, yaml.SequenceNode) and len(value) == len(node.value):
        for part, one in zip(node.value, value, strict=True):
            yield from _edit_of(part, one, text)
    elif not isinstance(node, yaml.ScalarNode) and not node.flow_style:
        raise ValueError("expected a value, not a section or list")
    else:
        start, end = node.start_mark.index, node.end_mark.index
        if yaml.safe_load(text[start:end]) != value:
            yield _Edit(start, end, _inline(value) if end > start else f" {_inline(value)}")


def _addition(node: Any, new: Tree, text: str) -> _Edit:
    """Add keys to a section: before its brace, or in lines of their own behind its last value."""
    items = [f"{key}: {_inline(value)}" for key, value in new.items()]
    if node.flow_style or not node.value:
        end = node.end_mark.index - 1
        filled = text[:end].rstrip()
        comma = "" if not node.value or filled.endswith(",") else ","
        return _Edit(len(filled), len(filled), f"{comma} {', '.join(items)}" if node.value else ", ".join(items))
    column = node.value[0][0].start_mark.column
    last = _last_index(node.value[-1][1])
    end = text.find("\n", last)
    end = len(text) if end < 0 else end
    return _Edit(end, end, "".join(f"\n{' ' * column}{item}" for item in items))


def _last_index(node: Any) -> int:
    """Where the last value in a node ends: blocks end only where something else begins."""
    if isinstance(node, yaml.ScalarNode) or node.flow_style or not node.value:
        return int(node.end_mark.index)
    last = node.value[-1]
    return _last_index(last[1] if isinstance(node, yaml.MappingNode) else last)


def _inline(value: Any) -> str:
    # Within a list, as within braces, texts are quoted that would not have to be elsewhere.
    return yaml.safe_dump([value], default_flow_style=True, sort_keys=False, width=_WIDTH)[1:-2]
