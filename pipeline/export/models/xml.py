"""XML as text: elements with numbers as attributes, all digits of them, indented."""

from collections.abc import Iterable
from xml.etree import ElementTree

import numpy as np
import numpy.typing as npt

Element = ElementTree.Element


def add(parent: Element, tag: str, **attributes: npt.ArrayLike) -> Element:
    """Append an element; numbers and arrays are written with all digits, a trailing underscore of a name is dropped."""
    return ElementTree.SubElement(parent, tag, {name.rstrip("_"): _text(value) for name, value in attributes.items()})


def numbers(values: npt.ArrayLike) -> str:
    """Write numbers with all their digits, zero without a sign, separated by spaces."""
    flat: Iterable[float] = (np.ravel(np.asarray(values, dtype=float)) + 0.0).tolist()
    return " ".join(map(repr, flat))


def axis_text(direction: npt.ArrayLike) -> str:
    """Write the direction of an axis; without decimals where it is along a coordinate."""
    values = np.asarray(direction, dtype=float)
    return " ".join(f"{value:.0f}" for value in values) if set(values.tolist()) <= {0.0, 1.0} else numbers(values)


def document(root: Element, comment: str) -> str:
    """Write a document with a comment at its head."""
    ElementTree.indent(root)
    text = ElementTree.tostring(root, encoding="unicode")
    return f'<?xml version="1.0" encoding="utf-8"?>\n<!-- {comment} -->\n{text}\n'


def _text(value: npt.ArrayLike) -> str:
    return value if isinstance(value, str) else numbers(value)
