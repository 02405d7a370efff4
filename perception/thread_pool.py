"""One pool of threads for all stages of perception, and no other threads beside it."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from functools import lru_cache
from threading import Lock
from typing import TypeVar

from threadpoolctl import ThreadpoolController

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


@contextmanager
def one_blas_thread() -> Iterator[None]:
    """Let products of matrices run in the caller's thread; also a decorator.

    The matrices of perception are small. The threads of BLAS gain nothing on them, and wait for the
    next product in a busy loop, on the cores that the fits need. The limit holds for the whole
    process until the last of several threads leaves it. It takes 20 µs.
    """
    _blas_limit.enter()
    try:
        yield
    finally:
        _blas_limit.leave()


class _BlasLimit:
    """The limit on the threads of BLAS, and the number of threads that asked for it."""

    def __init__(self) -> None:
        self._lock = Lock()
        self._users = 0
        self._libraries: ThreadpoolController | None = None
        self._restore: Callable[[], None] | None = None

    def enter(self) -> None:
        with self._lock:
            self._users += 1
            if self._users == 1:
                # The search for the libraries takes 8 ms: once, after all of them are loaded.
                self._libraries = self._libraries or ThreadpoolController()
                limit = self._libraries.limit(limits=1, user_api="blas")
                self._restore = limit.restore_original_limits

    def leave(self) -> None:
        with self._lock:
            self._users -= 1
            if self._users == 0 and self._restore is not None:
                self._restore()


_blas_limit = _BlasLimit()


@lru_cache(maxsize=1)
def _pool(process: int) -> ThreadPoolExecutor:
    # A forked process inherits no threads, so each process id gets its own pool.
    del process
    return ThreadPoolExecutor(os.cpu_count() or 1, thread_name_prefix="eyehand")
