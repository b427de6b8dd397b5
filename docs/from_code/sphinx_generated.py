"""Sphinx: fill in what pages take from the program, and find the public names that types refer to."""

from typing import Any

from docutils import nodes
from sphinx.application import Sphinx

import pipeline
from from_code.parts import fill_in


def _fill_in(app: Sphinx, name: str, content: list[str]) -> None:
    content[0] = fill_in(content[0])


def _public_name(app: Sphinx, env: Any, node: Any, shown: nodes.TextElement) -> nodes.Node | None:
    """Refer to a class by its public name, wherever the code has it from."""
    package, _, name = str(node.get("reftarget", "")).rpartition(".")
    ours = package.split(".")[0] in ("", "pipeline")
    if node.get("refdomain") != "py" or not ours or name not in pipeline.__all__:
        return None
    domain = env.get_domain("py")
    return domain.resolve_xref(env, node["refdoc"], app.builder, "obj", f"pipeline.{name}", node, shown)


def setup(app: Sphinx) -> dict[str, Any]:
    """Register both."""
    app.connect("source-read", _fill_in)
    app.connect("missing-reference", _public_name)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
