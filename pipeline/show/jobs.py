"""What the page asks for, done one at a time: of what is asked for again and again, only the last."""

from collections.abc import Callable
from threading import Condition

Job = Callable[[], None]


class Jobs:
    """A queue of jobs by name, filled by any thread; a job replaces one of its name that was not begun.

    Jobs of the names in `background` wait until there is nothing else.
    """

    def __init__(self, *background: str) -> None:
        self._background = background
        self._waiting: dict[str, Job] = {}
        self._changed = Condition()
        self._count = 0

    def post(self, name: str, job: Job) -> None:
        """Ask for a job, in place of the last one of this name."""
        with self._changed:
            self._waiting[name] = job
            self._changed.notify()

    def post_every(self, job: Job) -> None:
        """Ask for a job that none replaces."""
        with self._changed:
            self._count += 1
            self._waiting[f"#{self._count}"] = job
            self._changed.notify()

    def take(self, timeout_s: float | None = None) -> Job | None:
        """Wait for a job and take it; None if there is none in time."""
        with self._changed:
            if not self._changed.wait_for(lambda: bool(self._waiting), timeout_s):
                return None
            first = [name for name in self._waiting if name not in self._background] or list(self._waiting)
            return self._waiting.pop(first[0])
