"""Setting up by make, with stand-ins for Python, pip and uv that only write down what they are asked for."""

import os
import shutil
import subprocess
from dataclasses import dataclass
from pathlib import Path

import pytest

PROJECT = Path(__file__).parents[1]
PYTHON = """#!/bin/sh
echo "python $*" >> "$LOG"
case "$*" in
*"$FAIL"*) exit 1 ;;
"-m venv "*) mkdir -p .venv/bin; cp "$0" .venv/bin/python; printf '#!/bin/sh\\n' > .venv/bin/gantry-tau ;;
*" uv") printf '#!/bin/sh\\necho "uv $*" >> "$LOG"; case "uv $*" in *"$FAIL"*) exit 1;; esac\\n' > .venv/bin/uv ;;
esac
chmod +x .venv/bin/* 2> /dev/null
"""


@dataclass(frozen=True)
class Checkout:
    """A folder with what make needs."""

    folder: Path

    def make(self, *targets: str, fail: str = "never", succeeds: bool = True) -> list[str]:
        """Make targets, with what fails; return what was asked for: the environment, uv, sets by uv or pip."""
        log = self.folder / "log"
        log.write_text("")
        environment = {**os.environ, "LOG": str(log), "FAIL": fail}
        environment.pop("MAKEFLAGS", None)
        command = ["make", f"PYTHON={self.folder / 'python'}", *targets]
        done = subprocess.run(command, cwd=self.folder, env=environment, capture_output=True, text=True)
        assert (done.returncode == 0) == succeeds, done.stderr
        return [_short(line) for line in log.read_text().splitlines()]


def _short(line: str) -> str:
    if "-m venv" in line:
        return "venv"
    if line.endswith(" uv"):
        return "get uv"
    return f"{'uv' if line.startswith('uv ') else 'pip'} {line.split()[-1]}"


@pytest.fixture
def checkout(tmp_path: Path) -> Checkout:
    """Copy what make needs, and nothing that has been installed."""
    for name in ("Makefile", "pyproject.toml", "constraints.txt"):
        shutil.copy(PROJECT / name, tmp_path)
    (tmp_path / "python").write_text(PYTHON)
    (tmp_path / "python").chmod(0o755)
    return Checkout(tmp_path)


def test_a_run_installs_what_it_needs_once(checkout: Checkout) -> None:
    """By uv, without extras; the second time nothing, until what the set is made from has changed."""
    assert checkout.make("run") == ["venv", "get uv", "uv ."]
    assert checkout.make("run") == []
    later = (checkout.folder / ".venv" / ".run.ready").stat().st_mtime + 10
    os.utime(checkout.folder / "constraints.txt", (later, later))
    assert checkout.make("run") == ["uv ."]


def test_sets_are_added_and_bring_what_a_run_needs(checkout: Checkout) -> None:
    """Tests and measurements add theirs to one environment; a run after them installs nothing."""
    assert checkout.make(".venv/.dev.ready") == ["venv", "get uv", "uv .[dev]"]
    assert checkout.make("run") == []
    assert checkout.make("consumers") == ["uv .[consumers]"]
    assert checkout.make("consumers", "run", ".venv/.dev.ready") == []


def test_without_uv_pip_does_it(checkout: Checkout) -> None:
    """Whether uv cannot be had or cannot install."""
    assert checkout.make("run", fail="constraints.txt uv") == ["venv", "get uv", "pip ."]
    assert checkout.make(".venv/.dev.ready", fail="constraints.txt uv") == ["pip .[dev]"]
    (checkout.folder / ".venv" / ".venv.ready").unlink()
    (checkout.folder / ".venv" / ".run.ready").unlink()
    assert checkout.make("run", fail="uv pip") == ["venv", "get uv", "uv .", "pip ."]


def test_what_was_interrupted_is_begun_again(checkout: Checkout) -> None:
    """Half a package is not taken for a whole one, whichever set it is of."""
    assert checkout.make("run", fail="--editable", succeeds=False) == ["venv", "get uv", "uv .", "pip ."]
    assert checkout.make("run") == ["venv", "get uv", "uv ."]
    checkout.make(".venv/.dev.ready", fail="--editable", succeeds=False)
    assert checkout.make("run") == ["venv", "get uv", "uv ."]
    assert checkout.make(".venv/.dev.ready") == ["uv .[dev]"]
    shutil.rmtree(checkout.folder / ".venv")
    assert checkout.make("run", fail="-m venv", succeeds=False) == ["venv"]
    assert checkout.make("run") == ["venv", "get uv", "uv ."]
