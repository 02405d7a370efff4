"""The peak memory of a function call, and the return of freed memory."""

import sys

import numpy as np
import pytest

from eyehand.apps.bench import peak_memory
from eyehand.apps.bench.peak_memory import peak_megabytes, return_free_pages


def allocate_and_free(megabytes: int) -> int:
    """Allocate an array and free it."""
    array = np.ones(megabytes * 10**6, np.uint8)
    return int(array[-1])


def test_peak_counts_freed_memory():
    assert 38 < peak_megabytes(lambda: [allocate_and_free(40), allocate_and_free(10)]) < 60
    # An earlier, higher peak does not count.
    assert peak_megabytes(lambda: allocate_and_free(10)) < 25


def test_uses_tracemalloc_without_proc(monkeypatch, tmp_path):
    monkeypatch.setattr(peak_memory, "_RESET", tmp_path / "absent" / "clear_refs")
    assert 39 < peak_megabytes(lambda: allocate_and_free(40)) < 45


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="malloc_trim is a call of glibc")
def test_freed_memory_between_live_arrays_returns_to_the_system():
    before = peak_memory._status("VmRSS")
    blocks = [np.ones(100_000, np.uint8) for _ in range(2000)]
    kept = blocks[::50]
    del blocks
    return_free_pages()
    assert peak_memory._status("VmRSS") - before < 40e6
    assert len(kept) == 40
