"""Compare segmentation methods on the same frames of all kinds."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import partial

import numpy as np
from numpy.typing import NDArray

from eyehand.apps.console import tracked
from eyehand.perception import DepthFrame
from eyehand.perception.io import naming

from ..bench import Measured, Method, compare_methods
from .kinds import JudgedFrame, KindFrame, Score, score_by_kind, worst_kinds_mean

SegmentationMethod = Method[DepthFrame, NDArray[np.int32]]
NamedFrame = tuple[str, JudgedFrame]


FIGURES: tuple[str, ...] = ("worst_kinds_pct", "all_kinds_pct")
"""Mean score of the three worst kinds, and of all kinds."""
TIMED_SIZE = (480, 640)
"""Size (rows, columns) of the frames whose time counts, px. Frames of other sizes take other times.
"""


def compare_segmentations(
    methods: Sequence[SegmentationMethod], frames: Sequence[KindFrame], rounds: int
) -> list[Measured]:
    """Segment all frames with all methods. Pixels without a reading do not count in the score.

    Parameters
    ----------
    methods
        The methods. Each returns labels (H, W) of a frame, 0 = not an object.
    frames
        At least one frame.
    rounds
        See :func:`compare_methods`.

    Returns
    -------
    list of Measured
        In the order of the methods, with the figures of FIGURES. Times are those of the frames of
        640x480 px, or of all frames if there are none: the smaller of wall and processor time.

    Raises
    ------
    InputError
        If a frame cannot be read or segmented. The message names the frame.
    """
    named = [Method(m.name, m.setting, partial(_labels, m)) for m in methods]
    sizes: list[tuple[int, ...]] = []
    results = compare_methods(named, _loaded(frames, sizes), _score, rounds)
    timed = [size == TIMED_SIZE for size in sizes]
    timed = timed if any(timed) else [True] * len(timed)
    measured = []
    for result in results:
        shares = score_by_kind(frames, result.scores)
        figures = (worst_kinds_mean(shares), float(np.mean(list(shares.values()))))
        percent = {key: round(100 * share, 2) for key, share in zip(FIGURES, figures, strict=True)}
        # Other load lengthens the wall time of one thread, but not its processor time.
        wall, cpu = result.wall_ms[timed], result.cpu_ms[timed]
        times = replace(result, wall_ms=np.minimum(wall, cpu), cpu_ms=cpu)
        measured.append(Measured.of(times, percent))
    return measured


def _loaded(frames: Sequence[KindFrame], sizes: list[tuple[int, ...]]) -> Iterator[NamedFrame]:
    for frame in tracked(frames, "segmenting", len(frames)):
        with naming(frame.name):
            judged = frame.load()
        sizes.append(judged.frame.depth.shape)
        yield frame.name, judged


def _labels(method: SegmentationMethod, case: NamedFrame) -> NDArray[np.int32]:
    name, judged = case
    with naming(name):
        return method.run(judged.frame)


def _score(case: NamedFrame, labels: NDArray[np.int32]) -> Score:
    return case[1].judge(labels)
