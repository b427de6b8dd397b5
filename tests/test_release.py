"""What a release says of itself: its version, its licences, how to cite it."""

import re
import tomllib
from importlib import metadata
from pathlib import Path

import pytest
import yaml
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

from pipeline.export import CsvOptions, ExportOptions

PROJECT = Path(__file__).parents[1]
_ROW = re.compile(r"\| (?P<name>(?!package |---)[a-z0-9-]+) \| (?P<licence>[^|]+) \| [^|]+ \|")


def run_time_packages() -> dict[str, metadata.Distribution]:
    """Collect what a run needs, and what that needs, as it is installed; extras are left out."""
    found: dict[str, metadata.Distribution] = {}
    wanted = ["gantry-tau"]
    while wanted:
        name = canonicalize_name(wanted.pop())
        if name not in found:
            found[name] = metadata.distribution(name)
            needed = [Requirement(text) for text in found[name].requires or []]
            wanted += [one.name for one in needed if one.marker is None or one.marker.evaluate({"extra": ""})]
    del found["gantry-tau"]
    return found


def listed() -> dict[str, str]:
    """Read the table of licences."""
    lines = (PROJECT / "LICENSES.md").read_text().splitlines()
    return {found["name"]: found["licence"] for line in lines if (found := _ROW.fullmatch(line))}


def test_every_package_that_a_run_needs_is_listed_with_its_licence() -> None:
    """Nobody installs a package whose licence is not told; what is no longer needed is not listed."""
    packages = run_time_packages()
    assert {"casadi", "python-flint", "numpy", "markupsafe"} < set(packages)
    assert set(listed()) == set(packages)
    said = {name: one.metadata.get("License-Expression") for name, one in packages.items()}
    assert {name: text for name, text in said.items() if text} == {
        name: text for name, text in listed().items() if said[name]
    }
    assert {name for name, licence in listed().items() if "GPL" in licence} == {"casadi", "python-flint"}


def test_every_dependency_is_pinned() -> None:
    """Two installations a month apart have the same packages."""
    lines = (PROJECT / "constraints.txt").read_text().splitlines()
    pinned = {canonicalize_name(line.partition("==")[0]) for line in lines if "==" in line}
    assert set(run_time_packages()) <= pinned


def test_the_version_has_its_heading_among_the_changes() -> None:
    """What a version brought can be read; its number is in one place."""
    version = tomllib.loads((PROJECT / "pyproject.toml").read_text())["project"]["version"]
    assert f"\n## {version}\n" in (PROJECT / "CHANGELOG.md").read_text()
    assert "version" not in yaml.safe_load((PROJECT / "CITATION.cff").read_text())


def test_the_citation_names_program_and_paper() -> None:
    """Reference managers read it, and find whose method it is."""
    citation = yaml.safe_load((PROJECT / "CITATION.cff").read_text())
    project = tomllib.loads((PROJECT / "pyproject.toml").read_text())["project"]
    assert citation["license"] == project["license"]
    assert citation["authors"] == project["authors"]
    assert [one["family-names"] for one in citation["references"][0]["authors"]] == ["Murray", "Hovland", "Brogårdh"]


def test_a_deprecated_name_still_works_and_names_its_successor() -> None:
    """Old programs run on, and are told what to change."""
    with pytest.warns(DeprecationWarning, match="ExportOptions"):
        old = CsvOptions(decimals=12)
    assert isinstance(old, ExportOptions)
    assert old.decimals == 12
