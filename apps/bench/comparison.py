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
class Contestant(Generic[Case, Answer]):
    """A way to do it."""

    method: str
    """Whose it is."""
    name: str
    """At which setting."""
    run: Callable[[Case], Answer]
    """Does it. The same case gives the same answer."""


@dataclass(frozen=True)
class Tally(Generic[Case, Answer, Score]):
    """What a contestant took and reached, case by case."""

    contestant: Contestant[Case, Answer]
    wall_ms: NDArray[np.float64]
    """Wall time of the fastest round, (cases,), ms."""
    cpu_ms: NDArray[np.float64]
    """The same of processor time, of all threads: less shaken by what else runs."""
    scores: tuple[Score, ...]
    """What its answers are worth, by case."""


def take_turns(
    contestants: Sequence[Contestant[Case, Answer]],
    cases: Iterable[Case],
    score: Callable[[Case, Answer], Score],
    rounds: int,
) -> list[Tally[Case, Answer, Score]]:
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
    list of Tally
        In the order of the contestants.
    """
    times: list[NDArray[np.float64]] = []
    scores: list[list[Score]] = [[] for _ in contestants]
    opencv_threads = cv2.getNumThreads()
    # Threads are a dial of some contestants: what they call must not take more by itself.
    cv2.setNumThreads(1)
    try:
        for case in cases:
            fastest = np.full((len(contestants), 2), np.inf)
            for turn in range(0 if times else WARM_UP, rounds):
                for index, contestant in enumerate(contestants):
                    answer, seconds = _timed(contestant, case)
                    if turn >= 0:
                        fastest[index] = np.minimum(fastest[index], seconds)
                    if turn == 0:
                        scores[index].append(score(case, answer))
            times.append(1e3 * fastest)
    finally:
        cv2.setNumThreads(opencv_threads)
    by_contestant = np.moveaxis(np.array(times), 0, -1)
    return [
        Tally(contestant, wall_ms, cpu_ms, tuple(own))
        for contestant, (wall_ms, cpu_ms), own in zip(
            contestants, by_contestant, scores, strict=True
        )
    ]


def _timed(contestant: Contestant[Case, Answer], case: Case) -> tuple[Answer, tuple[float, float]]:
    """Answer, and wall and processor time in s."""
    cpu, wall = time.process_time(), time.perf_counter()
    answer = contestant.run(case)
    return answer, (time.perf_counter() - wall, time.process_time() - cpu)
