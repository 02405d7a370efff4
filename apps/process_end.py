"""Ordered ends of processes: after a termination signal, and of children without a parent."""

from __future__ import annotations

import ctypes
import os
import signal
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

PR_SET_PDEATHSIG = 1
"""Option of Linux' `prctl`: the signal that a process gets when its parent ends."""
TERMINATED = 128 + signal.SIGTERM
"""Exit code of a process that a termination signal ended, as shells report it."""


@contextmanager
def termination_unwinds() -> Iterator[None]:
    """Turn a termination signal into `SystemExit`, so that temporary files are removed.

    A handler that someone else has set is kept. Only the main thread can set one.
    """
    is_main = threading.current_thread() is threading.main_thread()
    if not is_main or signal.getsignal(signal.SIGTERM) != signal.SIG_DFL:
        yield
        return
    signal.signal(signal.SIGTERM, _unwind)
    try:
        yield
    finally:
        signal.signal(signal.SIGTERM, signal.SIG_DFL)


def end_with_parent(parent: int) -> None:
    """Let the system kill this process when its parent ends, however that happens.

    Without it a child that computes, or waits for a queue, outlives a parent that was killed. Other
    systems than Linux lack the call; nothing is changed there.

    Parameters
    ----------
    parent
        Process number of the parent, which may have ended already.
    """
    if not sys.platform.startswith("linux"):
        return
    ctypes.CDLL(None).prctl(PR_SET_PDEATHSIG, signal.SIGKILL)
    if os.getppid() != parent:
        os._exit(1)


def _unwind(_signal: int, _frame: Any) -> None:
    # The second signal ends the process at once, should the first one's clean-up hang.
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
    sys.exit(TERMINATED)
