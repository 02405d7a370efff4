"""Threads shared by all stages of perception, for kernels that release the interpreter's lock."""

from __future__ import annotations

import os
from concurrent.futures import ThreadPoolExecutor
from functools import lru_cache
from typing import TYPE_CHECKING, TypeVar

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable

Item = TypeVar("Item")
Result = TypeVar("Result")


def in_threads(step: Callable[[Item], Result], items: Iterable[Item], threads: int) -> list[Result]:
    """Apply a step to every item, in order, on at most so many threads.

    Parameters
    ----------
    step
        Depends on nothing but its item, and runs in parallel only where it releases the
        interpreter's lock (numba: ``nogil``). It must not call this function.
    items
        What it is applied to; long ones first end soonest.
    threads
        1 runs all in the caller's thread.
    """
    items = list(items)
    workers = min(threads, len(items))
    if workers < 2:
        return [step(item) for item in items]
    ahead = iter(list(enumerate(items)))
    results: dict[int, Result] = {}

    def work(_: int) -> None:
        # `next` of a list's iterator is one step under the lock: no item is taken twice.
        for number, item in ahead:
            results[number] = step(item)

    # The caller's thread works as well; a failure in any is raised here.
    others = [_pool(os.getpid()).submit(work, k) for k in range(1, workers)]
    try:
        work(0)
    finally:
        for other in others:
            other.result()
    return [results[number] for number in range(len(items))]


@lru_cache(maxsize=1)
def _pool(process: int) -> ThreadPoolExecutor:
    # A forked process has none of its parent's threads: one pool per process number.
    del process
    return ThreadPoolExecutor(os.cpu_count() or 1, thread_name_prefix="eyehand")
