"""Compare segmentation methods on the same frames."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from eyehand.perception.io import naming

from ..bench import Measured, Method, compare_methods
from .score import score_segmentation

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Sequence

    from numpy.typing import NDArray

    from eyehand.perception import DepthFrame

    from .dataset import FrameSource, LabelledFrame

    SegmentationMethod = Method[DepthFrame, NDArray[np.int32]]
    NamedFrame = tuple[str, LabelledFrame]

FIGURES: tuple[str, ...] = ("overlap_f_pct", "boundary_f_pct", "found_pct")
"""Means over frames of overlap F, boundary F, and the share of objects with an own F above 0.75."""


def compare_segmentations(
    methods: Sequence[SegmentationMethod], sources: Iterable[FrameSource], rounds: int
) -> list[Measured]:
    """Segment all frames with all methods. Pixels without a reading do not count in the score.

    Parameters
    ----------
    methods
        The methods. Each returns labels (H, W) of a frame, 0 = not an object.
    sources
        At least one frame.
    rounds
        See :func:`compare_methods`.

    Returns
    -------
    list of Measured
        In the order of the methods, with the figures of FIGURES.

    Raises
    ------
    InputError
        If a frame cannot be read or segmented. The message names the frame.
    """
    named = [Method(m.name, m.setting, partial(_labels, m)) for m in methods]
    measured = []
    for result in compare_methods(named, _loaded(sources), _shares, rounds):
        shares = np.round(100 * np.mean(result.scores, axis=0), 2).tolist()
        measured.append(Measured.of(result, dict(zip(FIGURES, shares, strict=True))))
    return measured


def _loaded(sources: Iterable[FrameSource]) -> Iterator[NamedFrame]:
    for source in sources:
        with naming(source.name):
            labelled = source.load()
        yield source.name, labelled


def _labels(method: SegmentationMethod, case: NamedFrame) -> NDArray[np.int32]:
    name, labelled = case
    with naming(name):
        return method.run(labelled.frame)


def _shares(case: NamedFrame, labels: NDArray[np.int32]) -> tuple[float, float, float]:
    _, labelled = case
    score = score_segmentation(labels, labelled.truth, ~labelled.frame.valid)
    return score.f, score.boundary_f, score.found
