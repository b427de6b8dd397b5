"""Commands that read a run: what is not a regular file is refused, and not waited for."""

import os
import signal
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.cli.calls import Call

NAMES = ("state.json", "config.yaml", "trajectory.npz", "certificate.json")
COMMANDS = (
    ("run", "machine.yaml", "--out", "out"),
    ("compare", "out", "--no-timing"),
    ("export", "out"),
    ("report", "out"),
    ("certify", "--check", "out"),
)


@pytest.fixture(autouse=True)
def impatient() -> Iterator[None]:
    """End a test that waits."""
    before = signal.signal(signal.SIGALRM, signal.default_int_handler)
    signal.alarm(60)
    yield
    signal.alarm(0)
    signal.signal(signal.SIGALRM, before)


@pytest.mark.parametrize("make", [os.mkfifo, lambda path: Path(path).symlink_to("/dev/zero"), os.mkdir])
def test_pipes_devices_and_folders(call: Call, config_file: Path, make) -> None:
    """In the place of every file, by every command that reads it: one message, and no change."""
    assert call("run", config_file, "--out", "out").exit_code == 0
    for name in NAMES:
        path = Path("out") / name
        path.rename("aside")
        make(path)
        before = path.lstat().st_ino, path.lstat().st_mode
        for command in COMMANDS:
            result = call(*command)
            reads = command[0] == "run" or name in ("state.json", "config.yaml")
            reads |= command[0] == "certify" and name == "certificate.json"
            # The certificate of a fake stage does not hold.
            assert result.exit_code in ((2,) if reads else (0, 1, 2)), (name, command, result.output)
        assert (path.lstat().st_ino, path.lstat().st_mode) == before
        path.rmdir() if path.is_dir() else path.unlink()
        Path("aside").rename(path)
