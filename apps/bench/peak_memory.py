"""The most memory that a piece of work holds at one time, over what was held before."""

from __future__ import annotations

import ctypes
import gc
import re
import tracemalloc
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Callable

MB = 1e6
"""Bytes in a megabyte."""
_RESET = Path("/proc/self/clear_refs")
_RESET_PEAK = "5"
"""Written there, it sets the process' peak back to what it holds now (proc(5))."""
_STATUS = Path("/proc/self/status")


def peak_megabytes(work: Callable[[], object]) -> float:
    """Run `work` and give the peak of the process' memory meanwhile, over that before, MB.

    On Linux this is the peak of the resident set, which holds what compiled kernels and OpenCV
    take as well; pages that are free inside the process are given back first, so that they count.
    Elsewhere it is the peak of what Python and NumPy take, which misses kernels' own arrays.
    """
    gc.collect()
    _give_back_free_pages()
    before = _resident_now()
    if before is None:
        return _traced(work)
    result = work()
    peak = _status("VmHWM")
    # Held until here, as a caller would hold it.
    del result
    return max(peak - before, 0) / MB


def _resident_now() -> int | None:
    """Set the peak back and give the resident set, bytes; None where the system cannot."""
    try:
        _RESET.write_text(_RESET_PEAK)
        return _status("VmRSS")
    except (OSError, ValueError):
        return None


def _status(key: str) -> int:
    found = re.search(rf"^{key}:\s*(\d+) kB$", _STATUS.read_text(), flags=re.MULTILINE)
    if found is None:
        raise ValueError(f"{_STATUS} has no {key}")
    return int(found[1]) * 1024


def _give_back_free_pages() -> None:
    try:
        trim = ctypes.CDLL(None).malloc_trim
    except (AttributeError, OSError, TypeError):
        # Only glibc has it; without it the figure may come out too low.
        return
    trim(0)


def _traced(work: Callable[[], object]) -> float:
    running = tracemalloc.is_tracing()
    if not running:
        tracemalloc.start()
    try:
        tracemalloc.reset_peak()
        before = tracemalloc.get_traced_memory()[0]
        result = work()
        peak = tracemalloc.get_traced_memory()[1]
        del result
    finally:
        if not running:
            tracemalloc.stop()
    return max(peak - before, 0) / MB
