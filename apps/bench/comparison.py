"""Time and score several methods on the same cases.

The speed of a shared machine varies. Therefore all methods run on a case before the next case
starts, in several rounds, and the fastest round counts. A slow phase of the machine then affects
all methods alike, or one round only.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import Generic, TypeVar

import cv2
import numpy as np
from numpy.typing import NDArray

Case = TypeVar("Case")
Answer = TypeVar("Answer")
Score = TypeVar("Score")

WARM_UP = -1
"""Index of the extra round on the first case. This round is not counted."""


@dataclass(frozen=True)
class Method(Generic[Case, Answer]):
    """A method at one setting."""

    name: str
    """Name of the method."""
    setting: str
    """Name of its setting."""
    run: Callable[[Case], Answer]
    """Solve a case. The same case must give the same answer."""


@dataclass(frozen=True)
class MethodResult(Generic[Case, Answer, Score]):
    """Times and scores of a method, case by case."""

    method: Method[Case, Answer]
    wall_ms: NDArray[np.float64]
    """Wall time of the fastest round, (cases,), ms."""
    cpu_ms: NDArray[np.float64]
    """Minimum processor time of all threads over the rounds, (cases,), ms. It depends less on other
    load."""
    scores: tuple[Score, ...]
    """Scores of its answers, by case."""


def compare_methods(
    methods: Sequence[Method[Case, Answer]],
    cases: Iterable[Case],
    score: Callable[[Case, Answer], Score],
    rounds: int,
) -> list[MethodResult[Case, Answer, Score]]:
    """Run all methods on all cases, in turns.

    Parameters
    ----------
    methods
        Methods to compare.
    cases
        At least one case.
    score
        Computes the score of an answer. Its run time does not count.
    rounds
        Runs of each method on each case, >= 1. An extra first run on the first case, in which
        kernels compile, is not counted.

    Returns
    -------
    list of MethodResult
        In the order of the methods.
    """
    times: list[NDArray[np.float64]] = []
    scores: list[list[Score]] = [[] for _ in methods]
    opencv_threads = cv2.getNumThreads()
    # Some methods set their own number of threads; OpenCV must not add more.
    cv2.setNumThreads(1)
    try:
        for case in cases:
            fastest = np.full((len(methods), 2), np.inf)
            for round_index in range(0 if times else WARM_UP, rounds):
                for index, method in enumerate(methods):
                    answer, seconds = _timed(method, case)
                    if round_index >= 0:
                        fastest[index] = np.minimum(fastest[index], seconds)
                    if round_index == 0:
                        scores[index].append(score(case, answer))
            times.append(1e3 * fastest)
    finally:
        cv2.setNumThreads(opencv_threads)
    by_method = np.moveaxis(np.array(times), 0, -1)
    return [
        MethodResult(method, wall_ms, cpu_ms, tuple(own))
        for method, (wall_ms, cpu_ms), own in zip(methods, by_method, scores, strict=True)
    ]


def _timed(method: Method[Case, Answer], case: Case) -> tuple[Answer, tuple[float, float]]:
    """Return the answer, and its wall and processor time in s."""
    cpu, wall = time.process_time(), time.perf_counter()
    answer = method.run(case)
    return answer, (time.perf_counter() - wall, time.process_time() - cpu)
