"""The workers of a study: those of this machine, or of a cluster that is there already."""

import asyncio
import contextlib
import logging
import time
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from pipeline.errors import UsageError
from pipeline.parallel import processors
from pipeline.study.extra import library

if TYPE_CHECKING:
    from distributed import Client

MEMORY = "memory_gb"
"""The resource of Dask's that every run takes a part of."""
CONNECT_S = 3.0
"""Time in which a scheduler has to be reached, and again, in which it has to answer."""
_COUNT_S = 2.0
"""How often the workers are counted."""
_MOST_DEATHS = 2
_LEAN: dict[str, Any] = {
    # Histories that people look at in a dashboard, which there is none of: they are the scheduler's growth.
    "distributed.admin.log-length": 100,
    "distributed.admin.low-level-log-length": 100,
    "distributed.diagnostics.computations.max-history": 1,
    "distributed.scheduler.allowed-failures": _MOST_DEATHS,
    "distributed.scheduler.worker-saturation": 1.0,
    # A sampling profiler and a watch on the event loop: neither is looked at.
    "distributed.worker.profile.enabled": False,
    "distributed.scheduler.dashboard.tasks.task-stream-length": 1,
}


@dataclass
class Pool:
    """Workers, and the client through which they are reached.

    Attributes
    ----------
    client : Client
        Dask's.
    address : str
        Where the scheduler is.
    """

    client: "Client"
    address: str
    _workers: list[tuple[int, float]] = field(default_factory=list, init=False)
    _slots: dict[float, int] = field(default_factory=dict, init=False)
    _counted: float = field(default=-1e9, init=False)

    def slots(self, memory_gb: float) -> int:
        """Count the runs of a size that all workers together can take at a time; 0 if none can take one."""
        self._count()
        if memory_gb not in self._slots:
            self._slots[memory_gb] = sum(min(threads, int(has_gb / memory_gb)) for threads, has_gb in self._workers)
        return self._slots[memory_gb]

    def most_memory_gb(self) -> float:
        """Give the memory of the largest worker; 0 if there is none."""
        self._count()
        return max((has_gb for _, has_gb in self._workers), default=0.0)

    def _count(self) -> None:
        """Ask for threads and memory of the workers, unless that is known."""
        if time.monotonic() - self._counted > _COUNT_S:
            workers = self.client.scheduler_info(n_workers=-1)["workers"].values()
            self._workers = [(one["nthreads"], float(one["resources"].get(MEMORY, 0.0))) for one in workers]
            self._slots.clear()
            self._counted = time.monotonic()

    @property
    def lives(self) -> bool:
        """Whether the scheduler can be reached."""
        return bool(self.client.status == "running")


@contextlib.contextmanager
def local_pool(workers: int | None, threads: int, memory_gb: float) -> Iterator[Pool]:
    """Start workers on this machine, by default as many as its processors and memory allow.

    Raises
    ------
    UsageError
        When Dask is not installed, or the machine does not have the memory.
    """
    distributed, dask = library("distributed"), library("dask")
    free_gb = library("psutil").virtual_memory().available / 1e9
    fitting = int(free_gb / memory_gb)
    if fitting < (workers or 1):
        raise UsageError(
            f"{workers or 1} workers need {(workers or 1) * memory_gb:.1f} GB, and {free_gb:.1f} GB are free.\n"
            f"  What to change: lower route.memory_gb to what a run takes up, or give at most --workers {fitting}."
        )
    count = workers or max(1, min(processors() // threads, fitting))
    with contextlib.ExitStack() as stack:
        with dask.config.set(_LEAN):
            # Workers are started once the cluster is one that can be closed, whatever ends this.
            cluster = distributed.LocalCluster(
                n_workers=0,
                threads_per_worker=1,
                processes=True,
                dashboard_address="127.0.0.1:0",
                host="127.0.0.1",
                memory_limit=0,
                resources={MEMORY: free_gb / count},
                silence_logs=50,
                preload=["pipeline.study.worker.preload"],
            )
            stack.callback(_close, cluster, 5.0)
            cluster.scale(count)
            cluster.sync(cluster.__aenter__)
            client = distributed.Client(cluster, set_as_default=False)
            stack.callback(_close, client, 2.0)
        yield Pool(client, cluster.scheduler_address)


def _close(opened: Any, timeout_s: float) -> None:
    """Close a cluster or a client, in whatever state it is."""
    with contextlib.suppress(Exception):
        opened.close(timeout=timeout_s)


@contextlib.contextmanager
def remote_pool(address: str, program: str) -> Iterator[Pool]:
    """Use the workers of a scheduler; each must be of this program.

    Raises
    ------
    UsageError
        When Dask is not installed, the scheduler does not answer, or a worker is of another program.
    """
    distributed = library("distributed")
    logging.getLogger("distributed").setLevel("CRITICAL")
    _require_scheduler(address)
    client = distributed.Client(address, timeout=CONNECT_S, set_as_default=False)
    try:
        require_program(client, program)
        client.register_plugin(_resources(distributed))
        yield Pool(client, address)
    finally:
        _close(client, 2.0)


def _require_scheduler(address: str) -> None:
    """Require that a scheduler answers at an address; a client would try for longer, and leave threads behind.

    Raises
    ------
    UsageError
        When it does not answer in time, or something else does.
    """
    try:
        # In a thread of its own: notebooks have an event loop in this one.
        with ThreadPoolExecutor(1) as thread:
            kind = thread.submit(lambda: asyncio.run(asyncio.wait_for(_kind_of(address), CONNECT_S))).result()
    except (OSError, ValueError, TypeError, MemoryError, TimeoutError) as error:
        # What does not speak Dask's language may be read as a message of any size.
        raise _silent(address, str(error) or type(error).__name__) from None
    if kind != "Scheduler":
        raise _silent(address, f"a {kind} does")


async def _kind_of(address: str) -> str:
    async with library("distributed").rpc(address, timeout=CONNECT_S) as peer:
        return str((await peer.identity())["type"])


def _silent(address: str, why: str) -> UsageError:
    return UsageError(
        f"no scheduler answers at {address} ({why}).\n"
        "  What to change: start one with `dask scheduler`, and give the address that it prints, such as "
        "tcp://10.0.0.1:8786; or leave out --scheduler to use this machine."
    )


def require_program(client: "Client", program: str) -> None:
    """Require that all workers have this program.

    Raises
    ------
    UsageError
        When one has another; names the worker, and both programs.
    """

    def found() -> str:
        # Sent as it is, so that it also runs where the program is missing or old.
        from importlib.metadata import PackageNotFoundError, version

        try:
            from pipeline.study.program import program_version
        except ImportError:
            try:
                return version("gantry-tau")
            except PackageNotFoundError:
                return "no gantry-tau"
        return program_version()

    for worker, name in client.run(found).items():
        if name != program:
            raise other_program(worker, name, program)


def other_program(worker: str, name: str, program: str) -> UsageError:
    """Make the error about a worker that has another program."""
    return UsageError(
        f"the worker {worker} has {name}, this is {program}: their results could differ.\n"
        "  What to change: install the same version there, and start the worker again."
    )


def _resources(distributed: Any) -> Any:
    """Make the plugin with which workers that were started without resources offer the memory they have."""

    class OfferMemory(distributed.WorkerPlugin):  # type: ignore[misc]  # the library is loaded when it is used
        name = "gantry-tau-memory"

        async def setup(self, worker: Any) -> None:
            if "memory_gb" not in worker.state.total_resources:
                psutil = library("psutil")

                limit = worker.memory_manager.memory_limit or psutil.virtual_memory().total
                await worker.set_resources(memory_gb=limit / 1e9)

    return OfferMemory()
