"""The command line as a process: its output and Ctrl-C, whatever happens to them."""

import os
import signal
import subprocess
import sys
import time
from functools import partial
from pathlib import Path

import pytest

from pipeline.startup import is_command_line
from tests.cli.calls import subprocess_env

ROOT = Path(__file__).parents[2]


def start(*arguments: str, **options: object) -> "subprocess.Popen[str]":
    """Start `python -m pipeline`; Ctrl-C reaches it even where the tests run in the background."""
    return subprocess.Popen(
        [sys.executable, "-m", "pipeline", *arguments],
        **{"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "cwd": ROOT, **options},
        text=True,
        env=subprocess_env(),
        preexec_fn=partial(signal.signal, signal.SIGINT, signal.SIG_DFL),
    )


@pytest.mark.parametrize(
    "arguments", [(), ("--version",), ("--help",), ("run", "--help"), ("check", "configs/quick.yaml")]
)
def test_a_full_device(arguments: tuple[str, ...]) -> None:
    """What cannot be printed is one message and an exit code, whoever prints it."""
    with Path("/dev/full").open("w") as full:
        process = start(*arguments, stdout=full)
        _, error = process.communicate(timeout=60)
    assert error == "error: standard output: No space left on device\n"
    assert process.returncode == 2


@pytest.mark.parametrize("unbuffered", ["", "1"])
def test_a_device_that_gets_full(tmp_path: Path, unbuffered: str) -> None:
    """What was written in part is an error, also where Python is asked not to buffer, as containers often do."""
    command = f"ulimit -f 4; exec {sys.executable} -m pipeline check --schema > {tmp_path / 'schema.json'}"
    environment = {**subprocess_env(), "PYTHONPATH": str(ROOT), "PYTHONUNBUFFERED": unbuffered}
    shell = subprocess.run(["sh", "-c", command], capture_output=True, text=True, env=environment, check=False)
    assert (tmp_path / "schema.json").stat().st_size > 0
    assert (shell.returncode, shell.stderr) == (2, "error: standard output: File too large\n")


@pytest.mark.parametrize("arguments", [("--version",), ("--help",), ("run",), ("check", "--schema")])
def test_a_reader_that_leaves(arguments: tuple[str, ...]) -> None:
    """A pipe that is closed ends the process quietly, also where help or a usage error is printed."""
    read_end, write_end = os.pipe()
    os.close(read_end)
    process = start(*arguments, stdout=write_end, stderr=write_end)
    os.close(write_end)
    process.communicate(timeout=60)
    assert process.returncode == 141


def test_closed_streams() -> None:
    """Without a stdout there is an error, without a stderr only an exit code; no file takes their place."""
    command = [sys.executable, "-m", "pipeline", "--version"]
    environment = {**subprocess_env(), "PYTHONPATH": str(ROOT)}
    shell = subprocess.run(
        ["sh", "-c", f"{' '.join(command)} >&-"], capture_output=True, text=True, env=environment, check=False
    )
    assert (shell.returncode, shell.stderr) == (2, "error: standard output: Bad file descriptor\n")
    shell = subprocess.run(
        ["sh", "-c", f"{' '.join(command)} <&- >&- 2>&-"], capture_output=True, env=environment, check=False
    )
    assert shell.returncode == 2


@pytest.mark.parametrize("times", [1, 10])
def test_interrupts_while_it_starts(tmp_path: Path, times: int) -> None:
    """Ctrl-C while modules are imported, once or ten times in a row: one line, 130, and nothing half-written."""
    for part in range(6):
        process = start("run", str(ROOT / "configs/quick.yaml"), "--out", "out", "-v", cwd=tmp_path)
        # Python starts before the program does, and is not the program's to quieten.
        time.sleep(0.1 + 0.1 * part)
        for _ in range(times):
            process.send_signal(signal.SIGINT)
            time.sleep(0.01)
        _, error = process.communicate(timeout=60)
        if "init_import_site" not in error and process.returncode != -signal.SIGINT:
            assert process.returncode == 130, error
            assert error.endswith("interrupted: nothing is lost, finished stages are kept\n")
            assert "Traceback" not in error
    assert list(tmp_path.rglob("*.part")) == []


def test_interrupt_while_commands_are_built(tmp_path: Path) -> None:
    """Ctrl-C between the imports and the command: one line and 130, too."""
    program = (
        "import os, signal, typer.main as building\n"
        "build = building.get_command\n"
        "building.get_command = lambda app: (os.kill(os.getpid(), signal.SIGINT), build(app))[1]\n"
        "from pipeline.cli import main\n"
        "main()\n"
    )
    command = [sys.executable, "-c", program, "--version"]
    environment = {**subprocess_env(), "PYTHONPATH": str(ROOT)}
    ended = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, env=environment, check=False)
    assert (ended.returncode, ended.stdout) == (130, "")
    assert ended.stderr == "interrupted: nothing is lost, finished stages are kept\n"


def test_only_the_command_line_ends_at_interrupts(monkeypatch: pytest.MonkeyPatch) -> None:
    """Importing the package leaves other programs as they are."""
    for name, expected in (("-m", True), ("/usr/bin/gantry-tau", True), ("pytest", False), ("", False)):
        monkeypatch.setattr(sys, "argv", [name])
        assert is_command_line() is expected
