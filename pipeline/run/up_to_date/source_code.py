"""The code that a module runs: every module of this package that it imports, directly or not, as one hash.

Imports are read from the sources, so that nothing is loaded. A name imported from a package counts as the module that
defines it: what else the package re-exports is left out.
"""

import ast
import functools
import hashlib
import os
import re
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import NamedTuple

PACKAGE = Path(__file__).parents[2]
"""The folder of this package."""

_NAME = PACKAGE.name
_TYPES_ONLY = re.compile(r"^([ \t]*)if TYPE_CHECKING:\n(?:\1[ \t]+.*\n|\s*\n)*", re.MULTILINE)
_IMPORT = re.compile(
    rf"^[ \t]*(from[ \t]+(?:{_NAME}\b|\.)[\w.]*[ \t]+import[ \t]+(?:\([^)]*\)|.*)|import[ \t]+{_NAME}\b.*)$",
    re.MULTILINE,
)
_CODE = {"py", "pyi", "pyc", "typed"}
"""Endings of files that are Python, or say that there are types."""

Import = tuple[str, str | None]
"""A module of this package, and the name imported from it; None for the whole module."""


def modules_of(roots: Iterable[str], package: Path = PACKAGE) -> frozenset[str]:
    """Find the modules that modules need: themselves, and all that they import, also within functions.

    Parameters
    ----------
    roots : iterable of str
        Full names of modules; those of other packages are ignored.
    package : Path
        The folder of the package.
    """
    found: set[str] = set()
    known = _files(package).modules
    pending = [root for root in roots if root in known]
    while pending:
        module = pending.pop()
        if module not in found:
            found.add(module)
            pending.extend(needed for needed in _needed(module, package) if shapes_results(needed))
    return frozenset(found)


@functools.cache
def code_sha256(roots: tuple[str, ...], package: Path = PACKAGE) -> str:
    """Hash the sources of all modules that modules need, and the files beside them that are not Python."""
    tree = _files(package)
    files = {tree.modules[module] for module in modules_of(roots, package)}
    files.update(asset for file in set(files) for asset in tree.assets.get(file.rpartition("/")[0], ()))
    digest = hashlib.sha256()
    for file in sorted(files):
        digest.update(f"{file}\n{_sha256(file, package)}\n".encode())
    return digest.hexdigest()


def shapes_results(module: str) -> bool:
    """Check whether results depend on the code of a module of this package.

    They depend on sections of the configuration by their values alone. In `run`, the makers shape results; the other
    modules decide what runs, and pass results on as they are.
    """
    if module.startswith(f"{_NAME}.run."):
        return module.startswith(f"{_NAME}.run.makers.")
    return not module.startswith(f"{_NAME}.config") or module == f"{_NAME}.config.file"


def imports_of(source: str) -> set[Import]:
    """List what a source imports from this package, except under `if TYPE_CHECKING`."""
    # Parsing these statements only is ten times as fast as parsing the whole source.
    statements = _IMPORT.findall(_TYPES_ONLY.sub("", source))
    return set(_read_imports(ast.parse("\n".join(statements))))


def _read_imports(tree: ast.Module) -> Iterator[Import]:
    for node in tree.body:
        if isinstance(node, ast.Import):
            yield from ((alias.name, None) for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            module = "." * node.level + (node.module or "")
            yield from ((module, None if alias.name == "*" else alias.name) for alias in node.names)


_TO_START_FROM = "configs"
"""The folder of configurations that `init` copies: no stage reads it."""


@functools.cache
def _needed(module: str, package: Path) -> frozenset[str]:
    """Find the modules that define what a module imports."""
    imported = imports_of((package / _files(package).modules[module]).read_text(encoding="utf-8"))
    return frozenset(found for source, name in imported if (found := _defining(source, name, package)))


@functools.cache
def _defining(module: str, name: str | None, package: Path) -> str | None:
    """Find the module that defines a name, through packages that re-export it; None if there is no such module."""
    known = _files(package).modules
    if name is not None and f"{module}.{name}" in known:
        return f"{module}.{name}"
    if name is not None and (exported := _exports(module, package).get(name)):
        return _defining(*exported, package)
    return module if module in known else None


@functools.cache
def _exports(module: str, package: Path) -> dict[str, Import]:
    """Map the names that the `__init__` of a package, or its stub, imports from this package to their origin."""
    folder = package.joinpath(*module.split(".")[1:])
    sources = [file for file in (folder / "__init__.py", folder / "__init__.pyi") if file.is_file()]
    exports: dict[str, Import] = {}
    for node in (node for file in sources for node in ast.parse(file.read_text(encoding="utf-8")).body):
        if isinstance(node, ast.ImportFrom):
            source = f"{module}.{node.module}" if node.level else node.module or ""
            exports |= {alias.asname or alias.name: (source, alias.name) for alias in node.names}
    return {name: origin for name, origin in exports.items() if origin[0].split(".")[0] == _NAME}


class _Files(NamedTuple):
    """The files of the package, relative to it: the source of every module, and by folder those that are not Python."""

    modules: dict[str, str]
    assets: dict[str, list[str]]


@functools.cache
def _files(package: Path) -> _Files:
    """List the files of the package; assets in a folder that is not a package belong to the package around it."""
    modules: dict[str, str] = {}
    assets: dict[str, list[str]] = {}
    owners: dict[str, str] = {}
    for path, folders, names in os.walk(package):
        folder = path.removeprefix(str(package)).strip("/")
        folders[:] = [name for name in folders if f"{folder}/{name}".lstrip("/") != _TO_START_FROM]
        owner = owners[folder] = folder if "__init__.py" in names else owners[folder.rpartition("/")[0]]
        for name in names:
            file = f"{folder}/{name}".lstrip("/")
            stem, _, ending = file.rpartition(".")
            if ending == "py":
                modules[".".join([_NAME, *stem.split("/")]).removesuffix(".__init__")] = file
            elif ending not in _CODE:
                assets.setdefault(owner, []).append(file)
    return _Files(modules, assets)


@functools.cache
def _sha256(file: str, package: Path) -> str:
    return hashlib.sha256((package / file).read_bytes()).hexdigest()
