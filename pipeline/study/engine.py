"""Leading a study: cases go to workers as these get free, rows come back and are kept."""

import contextlib
import functools
import queue
import time
from collections import Counter, deque
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol

from pipeline.errors import PipelineError, UsageError
from pipeline.progress import Monitor
from pipeline.study.cases import Case
from pipeline.study.config import Keep, RunConfig
from pipeline.study.pool import MEMORY, Pool, other_program
from pipeline.study.rows import Ending, Row
from pipeline.study.store import Store
from pipeline.study.worker.clear import clear_run
from pipeline.study.worker.process import run_request
from pipeline.study.worker.task import failed_row, keep_row, known_row

if TYPE_CHECKING:
    from distributed import Future

MOST_DEATHS = 3
"""How often a run may end its process before it is left."""
RUNS = "runs"
_POLL_S = 0.5
_AHEAD = 1.1
"""Runs that wait at workers beside those that run: nobody waits for the client."""


class Source(Protocol):
    """Where cases come from: a design that is fixed, or one that goes by the rows so far."""

    def ask(self) -> Case | None:
        """Give the next case; None if there is none, or none before more rows are told."""

    def tell(self, case: Case, row: Row) -> None:
        """Take the row of a case that was asked for."""


@dataclass(frozen=True)
class Fixed:
    """A design that is fixed: its cases in their order, whatever comes of them."""

    cases: Iterator[Case]

    def ask(self) -> Case | None:
        """Give the next case."""
        return next(self.cases, None)

    def tell(self, case: Case, row: Row) -> None:
        """Take no notice."""


@dataclass(frozen=True)
class Setting:
    """What holds for all runs of a study.

    Attributes
    ----------
    folder : Path
        The folder of the study.
    to, program : str
        The last stage, and the version of the program.
    run : RunConfig
        What a run may take.
    retry : bool
        Runs that ended for want of time or memory, or by a fault, are run again.
    """

    folder: Path
    to: str
    program: str
    run: RunConfig
    retry: bool = False

    def request(self, case: Case, again: bool) -> dict[str, Any]:
        """Put into plain data what a worker is asked."""
        return {
            "key": case.key,
            "data": case.data,
            "to": self.to,
            "folder": str(self.folder / RUNS / case.folder),
            "time_limit_s": self.run.time_limit_s,
            "threads": self.run.threads,
            "why_not": self.run.why_not,
            "program": self.program,
            "again": again,
        }


@dataclass
class Engine:
    """A study in progress.

    Attributes
    ----------
    setting : Setting
        What holds for all runs.
    open_pool : callable
        Gives the workers, once they are needed.
    store : Store
        Takes the rows.
    total : int or None
        How many cases there are, if that is known.
    monitor : Monitor
        Is told how far the study is.
    """

    setting: Setting
    open_pool: Callable[[], Pool]
    store: Store
    total: int | None
    monitor: Monitor
    _ended: "queue.SimpleQueue[Future]" = field(default_factory=queue.SimpleQueue, init=False)
    _running: "dict[Future, Case]" = field(default_factory=dict, init=False)
    _again: deque[Case] = field(default_factory=deque, init=False)
    _parked: dict[str, list[Case]] = field(default_factory=dict, init=False)
    _tries: dict[str, int] = field(default_factory=dict, init=False)
    _counts: dict[str, int] = field(default_factory=lambda: {"known": 0, "made": 0, "failed": 0}, init=False)
    _began: float = field(default_factory=time.monotonic, init=False)
    _open: Counter[str] = field(default_factory=Counter, init=False)

    @functools.cached_property
    def pool(self) -> Pool:
        """The workers."""
        self.monitor.progress("starting workers")
        return self.open_pool()

    def lead(self, source: Source) -> None:
        """Run every case that the source gives, and keep its row; those that are done are not run again.

        Raises
        ------
        UsageError
            When a worker has another program, or none has the memory that a run needs.
        PipelineError
            When the scheduler is lost: what is done is kept.
        """
        waiting: Case | None = None
        while True:
            waiting = waiting or self._next(source)
            while waiting is not None and len(self._running) < self._room(waiting):
                self._submit(waiting)
                waiting = self._next(source)
            if not self._running and waiting is None:
                return
            self._take_one(source)

    def _next(self, source: Source) -> Case | None:
        """Give the next case that has to be run; those that are known are told to the source."""
        if self._again:
            return self._again.popleft()
        while (case := source.ask()) is not None:
            row = self.store.row(case.key) or self._left(case)
            if row is None or self._is_open(row):
                self._open[case.folder] += 1
                if case.folder not in self._parked:
                    return case
                # The motion is being planned for another twin: it is there when that has ended.
                self._parked[case.folder].append(case)
                continue
            self._counts["known"] += 1
            self._settle(source, case, row)
        return None

    def _left(self, case: Case) -> Row | None:
        """Take the row that a run has left in its folder, if the client did not live to see it end."""
        row = known_row(self.setting.request(case, again=False))
        if row is not None:
            self.store.add(row)
        return row

    def _is_open(self, row: Row) -> bool:
        return not row.is_final(self.setting.run.time_limit_s) or (self.setting.retry and row.is_unsure)

    def _room(self, case: Case) -> int:
        """Count the runs that may be with workers, a few more than can run."""
        slots = self.pool.slots(case.memory_gb)
        if slots == 0:
            self._require_memory(case)
        return int(_AHEAD * slots + 0.9)

    def _require_memory(self, case: Case) -> None:
        most = self.pool.most_memory_gb()
        if 0.0 < most < case.memory_gb:
            raise UsageError(
                f"a run needs {case.memory_gb:.1f} GB, and the largest worker has {most:.1f} GB.\n"
                "  What to change: lower route.memory_gb to what a run takes up, or start fewer, larger workers."
            )
        self.monitor.progress(f"no worker at {self.pool.address} yet: waiting")

    def _submit(self, case: Case) -> None:
        self._parked.setdefault(case.folder, [])
        tried = self._tries.get(case.key, 0)
        self._tries[case.key] = tried + 1
        known = self.store.row(case.key)
        if known is not None and tried == 0:
            self.store.forget_deaths(case.key)
        future = self.pool.client.submit(
            run_request,
            self.setting.request(case, again=known is not None),
            # The scheduler keeps what it knows of every prefix of keys: there must be one only.
            key=f"run-{case.key}-{tried}",
            resources={MEMORY: case.memory_gb},
            retries=0,
        )
        self._running[future] = case
        future.add_done_callback(self._ended.put)

    def _take_one(self, source: Source) -> None:
        """Wait for a run to end, and keep what came of it."""
        try:
            future = self._ended.get(timeout=_POLL_S)
        except queue.Empty:
            if not self.pool.lives:
                raise self._lost() from None
            self._report()
            return
        case = self._running.pop(future)
        row = self._row(case, future)
        if row is None:
            self._again.append(case)
            return
        self._tries.pop(case.key, None)
        self._again += self._parked.pop(case.folder, [])
        self.store.add(row)
        self._open -= Counter((case.folder,))
        self._counts["made"] += 1
        self._settle(source, case, row)
        self._report()

    def _row(self, case: Case, future: "Future") -> Row | None:
        """Give the row of a run that ended; None if it has to run again."""
        if future.status in ("cancelled", "lost") or not self.pool.lives:
            raise self._lost()
        if future.status == "error":
            error = future.exception()
            if type(error).__name__ == "KilledWorker":
                return self._given_up(case, Ending.KILLED, "the workers that ran it ended")
            return self._given_up(case, Ending.ERROR, f"{type(error).__name__}: {error}")
        answer = future.result()
        if "other" in answer:
            raise other_program("that has joined", answer["other"], self.setting.program)
        if "row" in answer:
            return Row.read(answer["row"])
        if self.store.add_death(case.key, answer["ended"]) < MOST_DEATHS:
            return None
        message = f"{MOST_DEATHS} times; at last {answer['ended']}"
        return self._given_up(case, Ending.KILLED, message)

    def _given_up(self, case: Case, ending: Ending, message: str) -> Row:
        """Make the row of a run without an answer, and leave it in the run folder, as workers do with theirs."""
        request = self.setting.request(case, again=False)
        row = failed_row(request, ending, message, 0.0)
        with contextlib.suppress(OSError):
            keep_row(request, row)
        return row

    def _lost(self) -> PipelineError:
        done = self._counts["known"] + self._counts["made"]
        return PipelineError(
            f"the scheduler at {self.pool.address} is gone. {done:,} runs are done, and kept.\n"
            "  What to change: start it again, with its workers, and give the same command."
        )

    def _settle(self, source: Source, case: Case, row: Row) -> None:
        """Pass on a row that is kept; the run folder goes, if it need not be kept and no run at hand has it."""
        self._counts["failed"] += row.ending != Ending.DONE
        keep = self.setting.run.keep
        if keep is not Keep.ALL and not self._open[case.folder]:
            clear_run(self.setting.folder / RUNS / case.folder, keep)
        source.tell(case, row)

    def _report(self) -> None:
        """Tell how far the study is, and how long the rest takes if it goes on like this."""
        known, made, failed = (self._counts[name] for name in ("known", "made", "failed"))
        done = known + made
        text = f"{done:,} runs" if self.total is None else f"{done:,} of {self.total:,} runs"
        text += f", {failed:,} without a result" if failed else ""
        if self.total is not None and made:
            left_s = (time.monotonic() - self._began) / made * (self.total - done)
            text += f"; about {_duration(left_s)} left"
        self.monitor.progress(text, None if not self.total else done / self.total)


def _duration(seconds: float) -> str:
    if seconds < 90.0:
        return f"{seconds:.0f} s"
    if seconds < 5_400.0:
        return f"{seconds / 60.0:.0f} min"
    return f"{seconds / 3600.0:.1f} h"
