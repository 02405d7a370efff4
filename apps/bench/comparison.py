"""Time and score many ways of doing a thing on the same cases, in turns.

A shared machine is now faster, now slower. Here every contestant gets every case before the next
case comes, in several rounds, and of the rounds the fastest counts: what slows the machine down
slows all of them, or one round only, and the times stay comparable.
"""

from __future__ import annotations

import time
from dataclasses import dataclass
from typing import TYPE_CHECKING, Generic, TypeVar

import cv2
import numpy as np

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Sequence

    from numpy.typing import NDArray

Case = TypeVar("Case")
Answer = TypeVar("Answer")
Score = TypeVar("Score")

WARM_UP = -1
"""Round of the first case that does not count."""


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
    """What a contestant took and reached, case by case."""

    method: Method[Case, Answer]
    wall_ms: NDArray[np.float64]
    """Wall time of the fastest round, (cases,), ms."""
    cpu_ms: NDArray[np.float64]
    """The same of processor time, of all threads: less shaken by what else runs."""
    scores: tuple[Score, ...]
    """What its answers are worth, by case."""


def compare_methods(
    methods: Sequence[Method[Case, Answer]],
    cases: Iterable[Case],
    score: Callable[[Case, Answer], Score],
    rounds: int,
) -> list[MethodResult[Case, Answer, Score]]:
    """Let all contestants do all cases.

    Parameters
    ----------
    contestants
        Who takes part.
    cases
        At least one.
    score
        Worth of an answer; its time does not count.
    rounds
        How many times each case is done by each, >= 1. A first time on the first case, for
        kernels to compile and tables to fill, is not counted.

    Returns
    -------
    list of MethodResult
        In the order of the contestants.
    """
    times: list[NDArray[np.float64]] = []
    scores: list[list[Score]] = [[] for _ in methods]
    opencv_threads = cv2.getNumThreads()
    # Threads are a dial of some contestants: what they call must not take more by itself.
    cv2.setNumThreads(1)
    try:
        for case in cases:
            fastest = np.full((len(methods), 2), np.inf)
            for turn in range(0 if times else WARM_UP, rounds):
                for index, method in enumerate(methods):
                    answer, seconds = _timed(method, case)
                    if turn >= 0:
                        fastest[index] = np.minimum(fastest[index], seconds)
                    if turn == 0:
                        scores[index].append(score(case, answer))
            times.append(1e3 * fastest)
    finally:
        cv2.setNumThreads(opencv_threads)
    by_contestant = np.moveaxis(np.array(times), 0, -1)
    return [
        MethodResult(method, wall_ms, cpu_ms, tuple(own))
        for method, (wall_ms, cpu_ms), own in zip(methods, by_contestant, scores, strict=True)
    ]


def _timed(method: Method[Case, Answer], case: Case) -> tuple[Answer, tuple[float, float]]:
    """Answer, and wall and processor time in s."""
    cpu, wall = time.process_time(), time.perf_counter()
    answer = method.run(case)
    return answer, (time.perf_counter() - wall, time.process_time() - cpu)
