"""How the code is laid out: the order of packages is kept by `make lint`; here, what else makes rooms easy to find."""

import ast
from collections import Counter
from pathlib import Path

import pytest

PIPELINE = Path(__file__).parents[1] / "pipeline"
SOURCES = sorted(PIPELINE.rglob("*.py"))
MOST_MODULES, MOST_LINES = 13, 300
LINK_RAIL = {
    "pipeline.limits.link_rail": "the kind of limit",
    "pipeline.limits.kinds": "the list of kinds",
    "pipeline.machine.clearance": "the geometry",
    "pipeline.machine.geometry": "the value in the machine",
    "pipeline.machine.__init__": "the public name of the geometry",
    "pipeline.workspace.table": "the setting of a workspace as numbers",
    "pipeline.config.machine.links": "the key",
    "pipeline.certify.recheck.claims.distances.axis_distances": "the independent check",
}
"""Every module that may know of the distance between links and rails, and why."""


def _name(source: Path) -> str:
    return ".".join(source.relative_to(PIPELINE.parent).with_suffix("").parts)


def _identifiers(source: Path) -> set[str]:
    """Collect the names and the short strings of a module: comments and docstrings know nothing."""
    found = set()
    for node in ast.walk(ast.parse(source.read_text())):
        if isinstance(node, ast.Attribute):
            found.add(node.attr)
        elif isinstance(node, ast.Name):
            found.add(node.id)
        elif isinstance(node, ast.alias):
            found.update(node.name.split("."))
        elif isinstance(node, ast.Constant) and isinstance(node.value, str) and " " not in node.value:
            found.add(node.value)
        elif isinstance(node, ast.keyword | ast.arg) and node.arg:
            found.add(node.arg)
    return found


def test_a_kind_of_limit_is_known_to_few_modules():
    """The rest of the code loops over the limits that the configuration builds."""
    knowing = {_name(source) for source in SOURCES if any("link_rail" in name for name in _identifiers(source))}
    assert knowing <= set(LINK_RAIL)


@pytest.mark.parametrize("source", SOURCES, ids=_name)
def test_modules_are_short(source: Path):
    """A module has one idea."""
    assert len(source.read_text().splitlines()) <= MOST_LINES


def test_folders_are_small():
    """A newcomer finds a room by looking at a folder once."""
    counts = Counter(source.parent for source in SOURCES if source.name != "__init__.py")
    assert {str(folder): count for folder, count in counts.items() if count > MOST_MODULES} == {}


def test_test_modules_are_short():
    """Tests mirror the code, and are read like it."""
    tests = sorted((PIPELINE.parent / "tests").rglob("*.py"))
    assert [str(test) for test in tests if len(test.read_text().splitlines()) > 400] == []


def test_no_fixture_asks_for_the_scope_of_a_package():
    """Folders of tests are not packages, so that such a fixture would silently live as long as the session."""
    fixtures = Path(__file__).parent.rglob("conftest.py")
    scopes = {
        value.value
        for source in fixtures
        for value in ast.walk(ast.parse(source.read_text()))
        if isinstance(value, ast.Constant)
    }
    assert "package" not in scopes
    assert {"session", "module"} <= scopes
