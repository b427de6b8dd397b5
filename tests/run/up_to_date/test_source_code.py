"""The code of a stage: found by its imports, and hashed."""

import ast
import shutil
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

from pipeline.run.stage_specs import SPECS, code_roots
from pipeline.run.up_to_date.source_code import PACKAGE, code_sha256, imports_of, modules_of, shapes_results
from pipeline.stage import STAGES, Stage

SOURCES = sorted(file for file in PACKAGE.rglob("*.py*") if file.suffix in (".py", ".pyi"))


def stages_with_other_code(copy: Path) -> list[str]:
    """List the stages whose code differs in a copy of the package."""
    roots = {stage: code_roots(SPECS, stage) for stage in STAGES}
    return [stage for stage in STAGES if code_sha256(roots[stage], copy) != code_sha256(roots[stage])]


@pytest.fixture
def copy(tmp_path: Path) -> Path:
    """Copy the package."""
    return shutil.copytree(PACKAGE, tmp_path / PACKAGE.name, ignore=shutil.ignore_patterns("__pycache__"))


def edit(file: Path, old: str, new: str) -> None:
    """Replace a text that must be there."""
    text = file.read_text()
    assert old in text
    file.write_text(text.replace(old, new))


def test_a_copy_has_the_same_code(copy: Path) -> None:
    """The hash depends on the content of the package, not on where it is."""
    assert stages_with_other_code(copy) == []


@pytest.mark.parametrize(
    ("file", "old", "new", "stages"),
    [
        # What writes the section of a stage, and says it in words, belongs to the stage and to the report.
        ("summary/route.py", '"steps"', '"positions"', ["route", "figures"]),
        # Results are written as tables with so many decimals, and hashes of tables are in the report.
        ("export/csv.py", "DECIMALS = 12", "DECIMALS = 6", ["route", "refine", "certify", "retime", "figures"]),
        ("route/regions/build.py", "import", "import  ", ["regions"]),
        ("route/regions/table.py", "import", "import  ", ["regions", "route", "certify", "figures"]),
        ("route/planner.py", "import", "import  ", ["route"]),
        ("refine/refiner.py", "import", "import  ", ["refine"]),
        ("certify/certify.py", "import", "import  ", ["certify"]),
        ("retime/retime.py", "import", "import  ", ["retime", "figures"]),
        ("machine/kinematics.py", "import", "import  ", [str(stage) for stage in STAGES]),
        ("report/assets/page.css", "{", "{ ", ["figures"]),
        ("figures/style.py", "import", "import  ", ["figures"]),
        ("cli/application.py", "import", "import  ", []),
        ("run/execute.py", "import", "import  ", []),
        ("config/stages/retime.py", "import", "import  ", []),
    ],
)
def test_a_change_counts_for_the_stages_that_run_it(
    copy: Path, file: str, old: str, new: str, stages: list[str]
) -> None:
    """No stage keeps a result of other code, and none loses it to code that it does not run."""
    edit(copy / file, old, new)
    assert stages_with_other_code(copy) == stages


def test_imports_are_those_that_python_sees() -> None:
    """Reading the statements alone finds what reading the whole syntax tree finds, in every module."""
    for file in SOURCES:
        assert imports_of(file.read_text()) == set(imports_in(ast.parse(file.read_text()))), file


def imports_in(tree: ast.AST) -> Iterator[tuple[str, str | None]]:
    """Find imports from the package in a syntax tree, except those for types alone."""
    if isinstance(tree, ast.If) and isinstance(tree.test, ast.Name) and tree.test.id == "TYPE_CHECKING":
        children: list[ast.AST] = list(tree.orelse)
    else:
        children = list(ast.iter_child_nodes(tree))
    if isinstance(tree, ast.Import):
        yield from ((alias.name, None) for alias in tree.names if alias.name.split(".")[0] == PACKAGE.name)
    elif isinstance(tree, ast.ImportFrom) and (tree.level or (tree.module or "").split(".")[0] == PACKAGE.name):
        module = "." * tree.level + (tree.module or "")
        yield from ((module, alias.name) for alias in tree.names)
    for child in children:
        yield from imports_in(child)


def test_packages_do_nothing_when_imported() -> None:
    """A package on the way to a module is left out of the code: it must not have effects of its own."""
    inert = (ast.Import, ast.ImportFrom, ast.FunctionDef, ast.ClassDef)
    for file in (file for file in SOURCES if file.name == "__init__.py"):
        for node in ast.parse(file.read_text()).body:
            is_text = isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant)
            is_name = isinstance(node, ast.Assign) and all(
                isinstance(one, ast.Name | ast.Tuple) for one in node.targets
            )
            assert isinstance(node, inert) or is_text or is_name, file


def test_names_count_as_the_modules_that_define_them(tmp_path: Path) -> None:
    """Imports are followed through packages, stubs and functions, but not for types alone, and not in circles."""
    package = tmp_path / PACKAGE.name
    files = {
        "__init__.py": "",
        "start.py": "from pipeline.one import first\ndef f():\n    import pipeline.late\n"
        "if TYPE_CHECKING:\n    from pipeline.types import T\n",
        "one/__init__.py": "from pipeline.one.a import first\nfrom pipeline.one.b import second\n",
        "one/a.py": "from pipeline import lazy\nfrom pipeline.lazy import (  # why\n    third as other,\n)\n",
        "one/b.py": "",
        "late.py": "import pipeline.start\nimport json\nfrom pipeline.absent import x\n",
        "lazy/__init__.py": "",
        "lazy/__init__.pyi": "from .c import third as third\n",
        "lazy/c.py": "",
        "types.py": "",
    }
    for name, content in files.items():
        (package / name).parent.mkdir(parents=True, exist_ok=True)
        (package / name).write_text(content)
    expected = {"start", "one.a", "lazy", "lazy.c", "late"}
    assert modules_of(["pipeline.start", "numpy"], package) == {f"pipeline.{name}" for name in expected}


def test_what_only_decides_what_runs_is_left_out() -> None:
    """Sections of the configuration count by their values, and the makers are all of `run` that shapes results."""
    assert not shapes_results("pipeline.config.stages.refine")
    assert not shapes_results("pipeline.config")
    assert not shapes_results("pipeline.run.execute")
    assert shapes_results("pipeline.run.makers.route")
    assert shapes_results("pipeline.config.file")


def test_early_stages_do_not_depend_on_later_ones() -> None:
    """Each stage has the packages of its own work, and of the results it is given."""
    later = {
        Stage.REGIONS: ("refine", "certify", "retime", "figures", "report", "solvers"),
        Stage.ROUTE: ("refine", "certify", "retime"),
    }
    later |= {Stage.REFINE: ("certify", "retime", "figures"), Stage.RETIME: ("figures",)}
    for stage, packages in later.items():
        found = {module.split(".")[1] for module in modules_of(code_roots(SPECS, stage))}
        assert not found & set(packages)
    # The table of following errors is completed with the times of the motion: read, and not proven again.
    assert "pipeline.certify.certify" not in modules_of(code_roots(SPECS, Stage.RETIME))


def test_it_is_cheap(tmp_path: Path, copy: Path) -> None:
    """All hashes together take a fraction of a second, and nothing is loaded for them."""
    began = time.process_time()
    for stage in STAGES:
        code_sha256(code_roots(SPECS, stage), copy)
    assert time.process_time() - began < 0.3
