"""The public names of the package, by what the stub says they are for."""

import enum
import inspect
import re
from collections.abc import Iterator
from pathlib import Path

from pydantic import BaseModel

import pipeline

_STUB = Path(pipeline.__file__).with_suffix(".pyi")
_NAME = re.compile(r"^    (\w+) as \1,$", re.MULTILINE)


def public_groups() -> Iterator[tuple[str, list[str]]]:
    """Give the headings of the stub, each with its names in their order."""
    for part in re.split(r"^# ", _STUB.read_text(encoding="utf-8"), flags=re.MULTILINE):
        heading, _, rest = part.partition("\n")
        names = _NAME.findall(rest)
        if names:
            yield heading, names


def python_reference() -> str:
    """Write a section of autodoc directives for every group of public names."""
    return "\n".join(
        f"## {heading}\n\n```{{eval-rst}}\n" + "\n".join(map(_directive, names)) + "\n```\n"
        for heading, names in public_groups()
    )


def _directive(name: str) -> str:
    thing = getattr(pipeline, name)
    if inspect.isclass(thing) and issubclass(thing, BaseModel):
        return f".. autoclass:: pipeline.{name}()\n\n   See the :doc:`configuration </reference/configuration>`.\n"
    if inspect.isclass(thing):
        kind = "exception" if issubclass(thing, BaseException) else "class"
        plain = issubclass(thing, enum.Enum) or kind == "exception"
        return f".. auto{kind}:: pipeline.{name}\n" + ("" if plain else "   :members:\n")
    return f".. auto{'function' if callable(thing) else 'data'}:: pipeline.{name}\n"
