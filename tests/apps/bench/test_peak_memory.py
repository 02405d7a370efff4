"""The peak of a piece of work, whatever allocates it."""

import numpy as np

from eyehand.apps.bench import peak_memory
from eyehand.apps.bench.peak_memory import peak_megabytes


def hold(megabytes: int) -> int:
    """Fill an array and let it go again."""
    held = np.ones(megabytes * 10**6, np.uint8)
    return int(held[-1])


def test_the_peak_counts_what_was_freed_meanwhile():
    assert 38 < peak_megabytes(lambda: [hold(40), hold(10)]) < 60
    # An earlier, higher peak does not count.
    assert peak_megabytes(lambda: hold(10)) < 25


def test_where_the_system_tells_nothing_python_does(monkeypatch, tmp_path):
    monkeypatch.setattr(peak_memory, "_RESET", tmp_path / "absent" / "clear_refs")
    assert 39 < peak_megabytes(lambda: hold(40)) < 45
