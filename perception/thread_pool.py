"""One pool of threads for all stages of perception."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable
from concurrent.futures import ThreadPoolExecutor
from functools import lru_cache
from typing import TypeVar

Item = TypeVar("Item")
Result = TypeVar("Result")


def map_in_threads(
    function: Callable[[Item], Result], items: Iterable[Item], threads: int
) -> list[Result]:
    """Apply a function to every item on several threads and return the results in order.

    Parameters
    ----------
    function
        The function. Its result must depend on its item only. It runs in parallel only while it
        releases the GIL (numba: ``nogil``). It must not call `map_in_threads`.
    items
        The items. The total time is shortest when the slowest items come first.
    threads
        Maximum number of threads. 1 runs everything in the caller's thread.
    """
    items = list(items)
    workers = min(threads, len(items))
    if workers < 2:
        return [function(item) for item in items]
    remaining = iter(list(enumerate(items)))
    results: dict[int, Result] = {}

    def work(_: int) -> None:
        # The GIL makes `next` of a list's iterator atomic, so no item is processed twice.
        for number, item in remaining:
            results[number] = function(item)

    # The caller's thread works as well. `result` raises the exception of another thread.
    others = [_pool(os.getpid()).submit(work, k) for k in range(1, workers)]
    try:
        work(0)
    finally:
        for other in others:
            other.result()
    return [results[number] for number in range(len(items))]


@lru_cache(maxsize=1)
def _pool(process: int) -> ThreadPoolExecutor:
    # A forked process inherits no threads, so each process id gets its own pool.
    del process
    return ThreadPoolExecutor(os.cpu_count() or 1, thread_name_prefix="eyehand")
