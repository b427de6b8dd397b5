"""The wheel in an environment that holds nothing else: it plans, it brings its types, it needs no checkout."""

import os
import shutil
import subprocess
import sys
import tarfile
import zipfile
from dataclasses import dataclass
from pathlib import Path

import pytest

from pipeline.summary.versions import package_version

PROJECT = Path(__file__).parents[1]
SCRIPT = Path(__file__).parent / "data" / "user_script.py"
UV = Path(sys.executable).with_name("uv")
"""Where `make` installs it, if it can be had."""
LEFT_OUT = {"results", "build", "gantry_tau.egg-info"}
"""Beside hidden files and caches, what is not copied of the project's folder."""

pytestmark = pytest.mark.slow


@dataclass(frozen=True)
class Installed:
    """What was built, and where it was installed."""

    wheel: Path
    sdist: Path
    python: Path

    def call(self, folder: Path, *arguments: str) -> str:
        """Call the installed command in a folder; return what it prints."""
        environment = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}
        command = [self.python.with_name("gantry-tau"), *arguments]
        done = subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True)
        assert done.returncode == 0, done.stderr
        return done.stdout


def _left_out(folder: str, names: list[str]) -> set[str]:
    top = LEFT_OUT if Path(folder) == PROJECT else set()
    return {name for name in names if name in top or name.startswith(".") or name == "__pycache__"}


@pytest.fixture(scope="module")
def installed(tmp_path_factory: pytest.TempPathFactory) -> Installed:
    """Build a source distribution, a wheel from it, and install that with the pinned versions of what it needs."""
    folder = tmp_path_factory.mktemp("wheel")
    shutil.copytree(PROJECT, folder / "source", symlinks=True, ignore=_left_out)
    installer = ["--installer", "uv"] if UV.exists() else []
    environment = {**os.environ, "PATH": f"{UV.parent}:{os.environ['PATH']}"}
    build = [sys.executable, "-m", "build", *installer, "--outdir", folder / "dist", folder / "source"]
    subprocess.run(build, check=True, env=environment, capture_output=True)
    (wheel,), (sdist,) = (list((folder / "dist").glob(ending)) for ending in ("*.whl", "*.tar.gz"))

    subprocess.run([sys.executable, "-m", "venv", "--without-pip", folder / "venv"], check=True)
    python = folder / "venv" / "bin" / "python"
    pip = [UV, "pip", "install", "--python", python] if UV.exists() else [sys.executable, "-m", "pip"]
    if not UV.exists():
        pip += ["--python", python, "install"]
    subprocess.run([*pip, "--quiet", "--constraint", PROJECT / "constraints.txt", wheel], check=True)
    return Installed(wheel, sdist, python)


def test_it_plans_from_a_configuration_of_its_own(installed: Installed, tmp_path: Path) -> None:
    """Version, configuration, the whole run and its report: all from the wheel."""
    assert installed.call(tmp_path, "--version") == f"gantry-tau {package_version()}\n"
    installed.call(tmp_path, "init", "cell", "--base", "tiny")
    installed.call(tmp_path / "cell", "run", "cell.yaml", "--to", "route")
    assert (tmp_path / "cell" / "results" / "cell" / "route.csv").exists()
    installed.call(tmp_path / "cell", "report", "results/cell")
    assert (tmp_path / "cell" / "results" / "cell" / "report.html").stat().st_size > 1_000


def test_a_strict_user_finds_types(installed: Installed, tmp_path: Path) -> None:
    """A script that uses the public interface passes mypy's strict checks against the installed package."""
    script = shutil.copy(SCRIPT, tmp_path)
    mypy = [sys.executable, "-m", "mypy", "--strict", "--config-file=", "--python-executable", installed.python]
    environment = {name: value for name, value in os.environ.items() if name not in ("PYTHONPATH", "MYPYPATH")}
    done = subprocess.run([*mypy, script], cwd=tmp_path, env=environment, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout


def test_what_is_in_them(installed: Installed) -> None:
    """The wheel has the package and nothing else; the source distribution has what its tests need, too."""
    names = zipfile.ZipFile(installed.wheel).namelist()
    assert {name.split("/")[0].partition("-")[0] for name in names} == {"pipeline", "gantry_tau"}
    for name in ("py.typed", "__init__.pyi", "configs/agder.yaml", "report/assets/page.html.j2"):
        assert f"pipeline/{name}" in names
    with tarfile.open(installed.sdist) as archive:
        kept = {name.partition("/")[2] for name in archive.getnames()}
    assert {"configs/agder.yaml", "tests/test_wheel.py", "constraints.txt", "LICENSES.md", "CITATION.cff"} <= kept
