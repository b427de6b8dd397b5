"""The workers of a study: who is refused, and why."""

import psutil
import pytest

from pipeline.errors import UsageError
from pipeline.study.extra import library
from pipeline.study.pool import Pool, local_pool, require_program
from tests.study.fakes import FakeClient, done


def test_a_worker_of_another_program_is_named_with_both_versions() -> None:
    """Before anything runs; one of the same program is not."""
    client = FakeClient(done, programs={"tcp://a:1": "0.1.0 (code 1)", "tcp://b:2": "0.0.9"})
    with pytest.raises(UsageError, match=r"tcp://b:2 has 0\.0\.9, this is 0\.1\.0 \(code 1\)"):
        require_program(client, "0.1.0 (code 1)")  # type: ignore[arg-type]
    require_program(FakeClient(done, programs={"tcp://a:1": "1"}), "1")  # type: ignore[arg-type]


def test_slots_are_those_of_threads_and_memory() -> None:
    """A worker takes as many runs as it has threads, and as its memory holds."""
    pool: Pool = FakeClient(done, memory_gb=8.0).pool()
    assert (pool.slots(4.2), pool.slots(8.1)) == (2, 0)
    assert pool.most_memory_gb() == 8.0


def test_workers_are_counted_for_every_size() -> None:
    """One count of them serves all sizes."""
    client = FakeClient(done, memory_gb=8.0)
    pool = client.pool()
    assert [pool.slots(gb) for gb in (4.0, 9.0, 4.0)] == [2, 0, 2]


def test_more_workers_than_the_memory_holds_are_refused() -> None:
    """With how many there may be."""
    with pytest.raises(UsageError, match=r"at most --workers \d+"), local_pool(1_000, 1, 100.0):
        pass


def test_workers_end_where_starting_is_interrupted(monkeypatch: pytest.MonkeyPatch) -> None:
    """Ctrl-C before there is a client leaves no process."""

    def interrupted(*_: object, **__: object) -> None:
        raise KeyboardInterrupt

    before = set(psutil.Process().children(recursive=True))
    monkeypatch.setattr("distributed.Client", interrupted)
    with pytest.raises(KeyboardInterrupt), local_pool(1, 1, 0.1):
        pass
    left = set(psutil.Process().children(recursive=True)) - before
    assert not [process for process in left if "spawn_main" in " ".join(process.cmdline())]


def test_a_library_that_is_missing_is_one_line() -> None:
    """With what to install."""
    with pytest.raises(UsageError, match=r"not installed: pip install 'gantry-tau\[study\]'$"):
        library("distributed_is_not_there")
