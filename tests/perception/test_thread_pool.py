"""Steps on several threads give what one thread gives."""

import threading

import pytest
from hypothesis import given
from hypothesis import strategies as st

from eyehand.perception.thread_pool import map_in_threads


@given(items=st.lists(st.integers(), max_size=30), threads=st.integers(1, 5))
def test_results_come_in_order_of_items(items, threads):
    assert map_in_threads(lambda item: 2 * item, items, threads) == [2 * item for item in items]


def test_two_threads_are_at_work_at_once():
    meeting = threading.Barrier(2, timeout=10.0)
    assert len(map_in_threads(lambda _: meeting.wait(), range(2), 2)) == 2


@pytest.mark.parametrize("wrong", [0, 5])
def test_a_failure_in_any_thread_is_raised(wrong):
    def step(item: int) -> int:
        if item == wrong:
            raise ValueError(f"no {item}")
        return item

    with pytest.raises(ValueError, match=f"no {wrong}"):
        map_in_threads(step, range(8), 2)
