"""One pool of threads for all stages of perception, and a limit on the threads of BLAS."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from functools import lru_cache
from threading import Lock
from typing import TypeVar

from threadpoolctl import OpenBLASController, get_cached_controller

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
    """Limit BLAS to one thread. It is a context manager and a decorator.

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
    """The limit on the threads of BLAS, and the number of threads that use it."""

    def __init__(self) -> None:
        self.reset()

    def reset(self) -> None:
        """Start without users, as in a forked process: it has none of their threads."""
        self._lock = Lock()
        self._users = 0
        self._restore: Callable[[], None] | None = None

    def enter(self) -> None:
        with self._lock:
            if self._users == 0:
                # It searches again for libraries after new modules were imported.
                libraries = get_cached_controller().select(user_api="blas")
                _release_openblas()
                self._restore = libraries.limit(limits=1).restore_original_limits
            self._users += 1

    def leave(self) -> None:
        with self._lock:
            # A process forked inside the limit leaves it without having entered.
            self._users = max(self._users - 1, 0)
            if self._users == 0 and self._restore is not None:
                _release_openblas()
                self._restore()
                _release_openblas()


def _release_openblas() -> None:
    """Let the present thread change the limit, which threadpoolctl keeps to the one before."""
    OpenBLASController.clear_controlling_thread(force=True)


_blas_limit = _BlasLimit()


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_blas_limit.reset)


@lru_cache(maxsize=1)
def _pool(process: int) -> ThreadPoolExecutor:
    # A forked process inherits no threads, so each process id gets its own pool.
    del process
    return ThreadPoolExecutor(os.cpu_count() or 1, thread_name_prefix="eyehand")
