"""The store keeps rows, whatever becomes of the process that wrote them."""

import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from pipeline.errors import UsageError
from pipeline.study.rows import Row
from pipeline.study.store import STORE, Store

ROOT = Path(__file__).parents[2]
_WRITER = """
import os, sys
from pathlib import Path
from pipeline.study.rows import Row
from pipeline.study.store import Store
store = Store(Path(sys.argv[1]))
for k in range(1_000_000):
    store.add(Row(str(k), "done", figures={"x": k}))
    os.write(1, f"{k}\\n".encode())
"""


def test_rows_are_kept_and_replaced(tmp_path: Path) -> None:
    """A key has one row, the last."""
    row = Row("a", "done", figures={"path.kappa_max": 3.25})
    with Store(tmp_path) as store:
        store.add(Row("a", "error"))
        store.add(row)
        store.set_program("0.1")
    with Store(tmp_path) as store:
        assert list(store.rows()) == [row]
        assert (store.row("a"), store.row("b"), store.program()) == (row, None, "0.1")


def test_what_was_written_survives_a_kill(tmp_path: Path) -> None:
    """After kill -9 every row that was reported is there, whole."""
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    command = [sys.executable, "-c", _WRITER, str(tmp_path)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, env=environment) as process:
        assert process.stdout is not None
        reported = [process.stdout.readline() for _ in range(20)]
        process.send_signal(signal.SIGKILL)
        reported += process.stdout.readlines()
    whole = [int(line) for line in reported if line.endswith(b"\n")]
    with Store(tmp_path) as store:
        assert {int(row.key) for row in store.rows()} >= set(whole)


@pytest.mark.parametrize("content", [b"another program's file, and not a short one" * 40, b"SQLite format 3\0" * 99])
def test_what_is_no_store_is_refused(tmp_path: Path, content: bytes) -> None:
    """It is left as it is."""
    (tmp_path / STORE).write_bytes(content)
    with pytest.raises(UsageError, match="cannot be used"):
        Store(tmp_path)
    assert (tmp_path / STORE).read_bytes() == content
