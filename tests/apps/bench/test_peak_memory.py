"""The peak memory of a function call."""

import numpy as np

from eyehand.apps.bench import peak_memory
from eyehand.apps.bench.peak_memory import peak_megabytes


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
