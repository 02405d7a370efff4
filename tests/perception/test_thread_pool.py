"""Mapping over several threads equals mapping in one thread."""

import threading

import pytest
from hypothesis import given
from hypothesis import strategies as st

from eyehand.perception.thread_pool import map_in_threads


@given(items=st.lists(st.integers(), max_size=30), threads=st.integers(1, 5))
def test_results_keep_item_order(items, threads):
    assert map_in_threads(lambda item: 2 * item, items, threads) == [2 * item for item in items]


def test_two_threads_run_concurrently():
    barrier = threading.Barrier(2, timeout=10.0)
    assert len(map_in_threads(lambda _: barrier.wait(), range(2), 2)) == 2


@pytest.mark.parametrize("failing_item", [0, 5])
def test_failure_in_any_thread_is_raised(failing_item):
    def step(item: int) -> int:
        if item == failing_item:
            raise ValueError(f"no {item}")
        return item

    with pytest.raises(ValueError, match=f"no {failing_item}"):
        map_in_threads(step, range(8), 2)
