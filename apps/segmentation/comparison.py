"""Time and score many segmentations on the same frames, in turns."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from eyehand.perception.io import naming

from ..bench.comparison import Contestant, take_turns
from ..bench.dial_chart import Measured
from .score import score_segmentation

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Sequence

    from numpy.typing import NDArray

    from eyehand.perception import DepthFrame

    from .dataset import FrameSource, LabelledFrame

    Segmenter = Contestant[DepthFrame, NDArray[np.int32]]
    NamedFrame = tuple[str, LabelledFrame]

FIGURES: tuple[str, ...] = ("overlap_f_pct", "boundary_f_pct", "found_pct")
"""Means over frames of overlap F, boundary F, and the share of objects with an own F above 0.75."""


def run_contest(
    contestants: Sequence[Segmenter], sources: Iterable[FrameSource], rounds: int
) -> list[Measured]:
    """Let all contestants segment all frames, pixels without a reading left out of the score.

    Parameters
    ----------
    contestants
        Who takes part; they give labels (H, W) of a frame, 0 = not an object.
    sources
        The frames; at least one.
    rounds
        See :func:`take_turns`.

    Returns
    -------
    list of Measured
        In the order of the contestants, with the figures of FIGURES.

    Raises
    ------
    InputError
        If a frame cannot be read or segmented; the message names it.
    """
    named = [Contestant(c.method, c.name, partial(_labels, c)) for c in contestants]
    tallies = take_turns(named, _loaded(sources), _shares, rounds)
    results = []
    for contestant, tally in zip(contestants, tallies, strict=True):
        wall, cpu = (round(float(np.median(ms)), 3) for ms in (tally.wall_ms, tally.cpu_ms))
        shares = np.round(100 * np.mean(tally.scores, axis=0), 2).tolist()
        figures: dict[str, float] = dict(zip(FIGURES, shares, strict=True))
        results.append(Measured(contestant, wall, cpu, figures))
    return results


def _loaded(sources: Iterable[FrameSource]) -> Iterator[NamedFrame]:
    for source in sources:
        with naming(source.name):
            labelled = source.load()
        yield source.name, labelled


def _labels(contestant: Segmenter, case: NamedFrame) -> NDArray[np.int32]:
    name, labelled = case
    with naming(name):
        return contestant.run(labelled.frame)


def _shares(case: NamedFrame, labels: NDArray[np.int32]) -> tuple[float, float, float]:
    _, labelled = case
    score = score_segmentation(labels, labelled.truth, ~labelled.frame.valid)
    return score.f, score.boundary_f, score.found
