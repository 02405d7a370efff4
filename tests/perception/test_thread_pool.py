"""Mapping over several threads equals mapping in one thread."""

import threading

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from threadpoolctl import threadpool_info, threadpool_limits

from eyehand.perception.thread_pool import map_in_threads, one_blas_thread


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


def blas_threads() -> set[int]:
    libraries = [one for one in threadpool_info() if one["user_api"] == "blas"]
    assert libraries, f"NumPy {np.__version__} has no BLAS that threadpoolctl knows"
    return {one["num_threads"] for one in libraries}


def test_blas_has_one_thread_until_the_last_user_leaves():
    with threadpool_limits(limits=2, user_api="blas"):
        first, second = one_blas_thread(), one_blas_thread()
        with first:
            with second:
                assert blas_threads() == {1}
            assert blas_threads() == {1}
        assert blas_threads() == {2}


def test_blas_has_its_threads_again_after_an_error():
    with threadpool_limits(limits=2, user_api="blas"):
        with pytest.raises(ValueError, match="inside"), one_blas_thread():
            raise ValueError("inside")
        assert blas_threads() == {2}
