"""Measure the peak memory of a function call, and return freed memory to the system."""

from __future__ import annotations

import ctypes
import gc
import re
import tracemalloc
from collections.abc import Callable
from pathlib import Path

MB = 1e6
"""Bytes in a megabyte."""
_RESET = Path("/proc/self/clear_refs")
_RESET_PEAK = "5"
"""Writing this resets the peak resident set of the process, see proc(5)."""
_STATUS = Path("/proc/self/status")


def peak_megabytes(work: Callable[[], object]) -> float:
    """Run `work` and return by how much its peak memory exceeds the memory before, MB.

    On Linux this is the peak of the resident set. It includes memory of compiled kernels and
    OpenCV. Free pages are returned to the system first, so that their reuse counts. On other
    systems it is the peak that Python and NumPy allocate, without the arrays of kernels.
    """
    return_freed_memory()
    before = _resident_now()
    if before is None:
        return _traced(work)
    result = work()
    peak = _status("VmHWM")
    # The result counts: a caller would hold it too.
    del result
    return max(peak - before, 0) / MB


def return_freed_memory() -> None:
    """Free the objects of reference cycles, and return free pages to the system."""
    gc.collect()
    return_free_pages()


def return_free_pages() -> None:
    """Return free pages of the C library to the system, in about 13 ms.

    Freed arrays lie between live ones, so the C library keeps their pages: a process that clears
    packed tables grows by 85 MB per scene without this call. Only glibc has the function.
    """
    try:
        trim = ctypes.CDLL(None).malloc_trim
    except (AttributeError, OSError, TypeError):
        return
    trim(0)


def _resident_now() -> int | None:
    """Reset the peak and return the resident set, bytes; None on systems without it."""
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
