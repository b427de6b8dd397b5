"""What pages take from the program: every key, command, column and public name is in them."""

import re

import pytest
import typer

import pipeline
from from_code.parts import PARTS, fill_in
from pipeline.cli import app
from pipeline.config import Config
from pipeline.config.commented import commented_yaml
from pipeline.export.trajectory_columns import TRAJECTORY_COLUMNS
from pipeline.figures.run_figures import FIGURES
from tests.docs.pages import PAGES
from tests.docs.test_configuration import keys


def test_every_key_is_described() -> None:
    """Each section has a table with all its keys, whatever its place."""
    schema = Config.model_json_schema()
    text = fill_in("<!-- from code: configuration keys -->")
    cells = set(re.findall(r"^\| `(\w+)` \|", text, re.MULTILINE))
    assert {key.rsplit(".", 1)[-1] for key in keys(schema, schema["$defs"])} == cells
    assert not [line for line in text.splitlines() if line.startswith("|") and line.count(" | ") < 3]


def test_links_between_sections_lead_to_headings() -> None:
    """A key that is a section links to where that section is described."""
    text = fill_in("<!-- from code: configuration keys -->")
    headings = [heading.lower().replace(" ", "-") for heading in re.findall(r"^#+ (.*)$", text, re.MULTILINE)]
    assert len(set(headings)) == len(headings)
    assert set(re.findall(r"\]\(#([^)]+)\)", text)) <= {re.sub(r"[^\w-]", "", heading) for heading in headings}


def test_the_reference_configuration_is_shown(agder_config: Config) -> None:
    """The block is what `gantry-tau check configs/agder.yaml --yaml` prints."""
    assert fill_in("<!-- from code: configuration yaml -->") == f"```yaml\n{commented_yaml(agder_config)}```\n"


def test_every_command_and_option_is_described() -> None:
    """All commands are there, with all options and examples."""
    text = fill_in("<!-- from code: commands -->")
    commands = typer.main.get_command(app).commands  # type: ignore[attr-defined]
    assert re.findall(r"^## (\S+)$", text, re.MULTILINE) == list(commands)
    for command in commands.values():
        for option in command.params:
            assert all(f"`{name}`" in text for name in option.opts if name.startswith("-"))
    assert text.count("Examples:") == len(commands)


def test_tables_of_commands_have_three_cells() -> None:
    """A bar within a cell does not split it, and code of help texts stays code."""
    text = fill_in("<!-- from code: commands -->")
    rows = [line for line in text.splitlines() if line.startswith("| ")]
    assert {len(re.findall(r"(?<!\\)\|", row)) for row in rows} == {4}
    assert any("`CONFIG \\| RUN`" in row for row in rows)
    assert "from `simulate --output FILE`" in text


def test_every_column_and_figure_is_described() -> None:
    """The tables have a row for each."""
    columns, figures = (fill_in(f"<!-- from code: {part} -->") for part in ("trajectory columns", "figures"))
    assert re.findall(r"^\| `(\w+)` \|", columns, re.MULTILINE) == [one.name for one in TRAJECTORY_COLUMNS]
    assert re.findall(r"^\| `(\w+)` \| \S", figures, re.MULTILINE) == [one.name for one in FIGURES]


def test_every_public_name_is_described() -> None:
    """Autodoc is asked for all names of the stub, each once."""
    text = fill_in("<!-- from code: python interface -->")
    assert sorted(re.findall(r"^\.\. auto\w+:: pipeline\.(\w+)(?:\(\))?$", text, re.MULTILINE)) == sorted(
        pipeline.__all__
    )


def test_the_reference_run_is_shown() -> None:
    """Every stage has its figures."""
    text = fill_in("<!-- from code: reference run -->")
    assert re.findall(r"^\| (\w+) \|", text, re.MULTILINE)[1:] == [
        "regions",
        "route",
        "path",
        "certificate",
        "trajectory",
    ]


def test_notebooks_are_pages() -> None:
    """Text and code are there, without commands to Jupyter."""
    text = fill_in("<!-- from code: notebook [1_machine_and_singularities] -->")
    assert text.startswith("# The machine and its singularities")
    assert "```python\nimport numpy as np" in text
    assert "%matplotlib" not in text


def test_all_parts_are_used_and_known() -> None:
    """No part is made in vain, and no page asks for one that does not exist."""
    used = {name for page in PAGES for name in re.findall(r"<!-- from code: ([a-z ]+?)(?: \[|\s-->)", page.read_text())}
    assert used == set(PARTS)
    with pytest.raises(KeyError):
        fill_in("<!-- from code: nothing -->")
