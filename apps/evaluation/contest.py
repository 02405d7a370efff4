"""Time and score many segmentations on the same frames, in turns.

A shared machine is now faster, now slower. Here every contestant gets every frame before the next
frame comes, in several rounds, and of the rounds the fastest counts: what slows the machine down
slows all of them, or one round only, and the times stay comparable.
"""

from __future__ import annotations

import time
from dataclasses import dataclass
from typing import TYPE_CHECKING

import cv2
import numpy as np

from eyehand.perception.input_file import naming

from .segmentation_score import score_segmentation

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Sequence

    from numpy.typing import NDArray

    from eyehand.perception import DepthFrame

    from .segmentation_dataset import FrameSource


WARM_UP = -1
"""Round of the first frame that does not count."""


@dataclass(frozen=True)
class Contestant:
    """A way to segment."""

    method: str
    """Whose it is."""
    name: str
    """At which setting."""
    run: Callable[[DepthFrame], NDArray[np.int32]]
    """Labels (H, W) of a frame; 0 = not an object. The same frame gives the same labels."""


@dataclass(frozen=True)
class Result:
    """What a contestant reached."""

    contestant: Contestant
    median_ms: float
    """Median over frames of the fastest round's wall time, ms."""
    median_cpu_ms: float
    """The same of processor time, of all threads: less shaken by what else runs, ms."""
    overlap_f_pct: float
    """Mean overlap F over frames, per cent."""
    boundary_f_pct: float
    """Mean boundary F, per cent."""
    found_pct: float
    """Mean share of objects with an own F above 0.75, per cent."""


def run_contest(
    contestants: Sequence[Contestant], sources: Iterable[FrameSource], rounds: int
) -> list[Result]:
    """Let all contestants segment all frames, pixels without a reading left out of the score.

    Parameters
    ----------
    contestants
        Who takes part.
    sources
        The frames; at least one.
    rounds
        How many times each frame is segmented by each, >= 1. A first time on the first frame, for
        kernels to compile and tables to fill, is not counted.

    Returns
    -------
    list of Result
        In the order of the contestants.

    Raises
    ------
    InputError
        If a frame cannot be read.
    """
    times: list[NDArray[np.float64]] = []
    shares: list[list[tuple[float, float, float]]] = [[] for _ in contestants]
    opencv_threads = cv2.getNumThreads()
    # Threads are a dial of the segmentation: what it calls must not take more by itself.
    cv2.setNumThreads(1)
    try:
        for source in sources:
            with naming(source.name):
                labelled = source.load()
                ignore = ~labelled.frame.valid
                fastest = np.full((len(contestants), 2), np.inf)
                for turn in range(0 if times else WARM_UP, rounds):
                    for index, contestant in enumerate(contestants):
                        labels, seconds = _timed(contestant, labelled.frame)
                        if turn >= 0:
                            fastest[index] = np.minimum(fastest[index], seconds)
                        if turn == 0:
                            score = score_segmentation(labels, labelled.truth, ignore)
                            shares[index].append((score.f, score.boundary_f, score.found))
            times.append(fastest)
    finally:
        cv2.setNumThreads(opencv_threads)
    medians = np.round(1e3 * np.median(times, axis=0), 3)
    means = np.round(100 * np.mean(shares, axis=1), 2)
    return [
        Result(contestant, *wall_and_cpu.tolist(), *figures.tolist())
        for contestant, wall_and_cpu, figures in zip(contestants, medians, means, strict=True)
    ]


def _timed(
    contestant: Contestant, frame: DepthFrame
) -> tuple[NDArray[np.int32], tuple[float, float]]:
    """Labels, and wall and processor time in s."""
    cpu, wall = time.process_time(), time.perf_counter()
    labels = contestant.run(frame)
    return labels, (time.perf_counter() - wall, time.process_time() - cpu)
