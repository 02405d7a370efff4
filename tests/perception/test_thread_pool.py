"""Mapping over several threads equals mapping in one thread."""

import threading
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from typing import TypeVar

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from threadpoolctl import OpenBLASController, threadpool_info, threadpool_limits

from eyehand.perception.thread_pool import map_in_threads, one_blas_thread

Result = TypeVar("Result")


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


def threads_of(api: str) -> set[int]:
    np.linalg.svd(np.eye(2))
    libraries = [one for one in threadpool_info() if one["user_api"] == api]
    return {one["num_threads"] for one in libraries}


def in_worker(function: Callable[[], Result]) -> Result:
    with ThreadPoolExecutor(1) as pool:
        return pool.submit(function).result()


@pytest.fixture
def two_blas_threads() -> Iterator[None]:
    with threadpool_limits(limits=2, user_api="blas"):
        assert threads_of("blas") == {2}
    # Outside of the block, no thread owns the limit any more.
    before = threadpool_limits(limits=2, user_api="blas")
    OpenBLASController.clear_controlling_thread(force=True)
    yield
    OpenBLASController.clear_controlling_thread(force=True)
    before.restore_original_limits()
    OpenBLASController.clear_controlling_thread(force=True)


@pytest.mark.usefixtures("two_blas_threads")
@pytest.mark.parametrize("first_leaves_last", [False, True])
def test_blas_has_one_thread_until_the_last_user_leaves(first_leaves_last):
    """The other user is another thread."""
    one, other = one_blas_thread(), one_blas_thread()
    one.__enter__()
    in_worker(other.__enter__)
    assert threads_of("blas") == {1}
    leave = [
        lambda: one.__exit__(None, None, None),
        lambda: in_worker(lambda: other.__exit__(None, None, None)),
    ]
    if first_leaves_last:
        leave.reverse()
    leave[0]()
    assert threads_of("blas") == {1}
    leave[1]()
    assert threads_of("blas") == {2}


@pytest.mark.usefixtures("two_blas_threads")
def test_blas_is_limited_in_one_thread_after_another():
    def inside() -> set[int]:
        with one_blas_thread():
            return threads_of("blas")

    assert inside() == {1}
    assert in_worker(inside) == {1}
    assert threads_of("blas") == {2}


@pytest.mark.usefixtures("two_blas_threads")
def test_limit_ends_with_an_error_and_leaves_openmp_alone():
    openmp = threads_of("openmp")
    with one_blas_thread():
        assert threads_of("openmp") == openmp
    with pytest.raises(ValueError, match="inside"), one_blas_thread():
        raise ValueError("inside")
    assert threads_of("blas") == {2}
    assert threads_of("openmp") == openmp
