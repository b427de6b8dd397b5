"""Work in blocks and in threads."""

import threading
import time
from functools import partial
from itertools import chain

import pytest

from pipeline.parallel import WORKERS, blocks, in_parallel


@pytest.mark.parametrize(("count", "size"), [(0, 3), (1, 3), (3, 3), (7, 3), (9, 100)])
def test_blocks_hold_every_row_once_in_order(count, size):
    """None is longer than asked for, and no rows make no block."""
    rows = list(range(count))
    parts = [rows[block] for block in blocks(count, size)]
    assert list(chain.from_iterable(parts)) == rows
    assert all(0 < len(part) <= size for part in parts)


def test_results_come_in_the_order_of_the_tasks():
    """Whichever ends first."""

    def late(number):
        time.sleep(0.01 * (number % 3 == 0))
        return number

    assert list(in_parallel(partial(late, number) for number in range(20))) == list(range(20))


def test_no_more_threads_than_workers():
    """Blocks of all threads together are what memory has to hold."""
    names = set(in_parallel([lambda: threading.current_thread().name] * 50))
    assert 1 <= len(names) <= WORKERS


def test_an_error_of_a_task_is_the_callers():
    """What came before it is still given."""

    def fail():
        raise KeyError("here")

    results = in_parallel([lambda: 1, fail])
    assert next(results) == 1
    with pytest.raises(KeyError, match="here"):
        next(results)
