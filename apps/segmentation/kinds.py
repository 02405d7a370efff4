"""All kinds of development data, each frame with a function that scores labels.

A kind is data of one sort: a family of synthetic scenes, a folder of labelled frames, or the frames
of one camera that are annotated by points. A mean over all frames hides the kinds that fail.
Therefore every kind has one score, and the worst kinds count: mean overlap F of labelled frames,
share of right objects of annotated ones.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from eyehand.errors import InputError
from eyehand.perception import DepthFrame

from .dataset import Coding, DatasetOptions, FrameSource, open_dataset
from .point_frames import PointFrame, frames_by_camera, read_point_frames, score_points
from .score import score_segmentation
from .synthetic_frames import FAMILIES, synthetic_sources

SYNTHETIC_FRAMES = 6
"""Default number of scenes per synthetic family."""
SYNTHETIC_NOISE = "realistic"
SYNTHETIC_SOURCE = "synthetic"
"""All families share one generator and one camera: they are one source."""
WORST_KINDS = 3
"""Number of kinds whose mean is the accuracy of a setting. The single worst kind has as few as 8
objects, and one of them is more than most settings differ."""


@dataclass(frozen=True)
class KindOptions:
    """Development data: synthetic families, and folders of real frames where they exist.

    Raises
    ------
    InputError
        If a number is out of range.
    """

    dataset: Path | None = None
    """Folder of labelled frames, one kind. Default: none."""
    labels: Coding = "plain"
    """Coding of the labels in .npz files: plain (object numbers) or osd."""
    points: Path | None = None
    """Folder of frames annotated by points. The frames of each camera are a kind. Default: none."""
    kinds: tuple[str, ...] = ()
    """Kinds to keep. Default: all."""
    frames: int | None = None
    """Maximum number of frames per kind, spread evenly. Default: 6 synthetic, all real ones."""
    seed: int = 0
    """First seed of synthetic scenes."""

    def __post_init__(self) -> None:
        if self.frames is not None and self.frames < 1:
            raise InputError(f"--frames must be >= 1, got {self.frames}")
        if self.seed < 0:
            raise InputError(f"--seed must be >= 0, got {self.seed}")


class Score(NamedTuple):
    """The score of a segmentation on a frame."""

    right: float
    """Number of objects right of an annotated frame, overlap F (0-1) of a labelled one."""
    total: int
    """Number of objects of an annotated frame, 1 of a labelled one."""


@dataclass(frozen=True)
class JudgedFrame:
    """A depth frame and its truth."""

    frame: DepthFrame
    """The depth frame."""
    judge: Callable[[NDArray[np.int32]], Score]
    """Score labels (H, W), 0 = no object."""
    truth: NDArray[np.int32]
    """(H, W): object 1..n, -1 = background, 0 = unknown. Annotated frames know single pixels."""


@dataclass(frozen=True)
class KindFrame:
    """A frame of one kind that is loaded on demand."""

    name: str
    """Name, unique within its kind."""
    kind: str
    """Kind of data."""
    source: str
    """Origin. Settings of left-out data are chosen without the whole source."""
    load: Callable[[], JudgedFrame]
    """Read or render the frame. Every call returns the same frame."""


def open_kinds(options: KindOptions) -> list[KindFrame]:
    """List the frames of all kinds, kind by kind.

    Raises
    ------
    InputError
        If a folder cannot be read, or if a name is no kind.
    """
    wanted = SYNTHETIC_FRAMES if options.frames is None else options.frames
    families = [f for f in FAMILIES if not options.kinds or f in options.kinds]
    frames = [
        KindFrame(source.name, family, SYNTHETIC_SOURCE, partial(_judged_labelled, source))
        for family in families
        for source in synthetic_sources(
            [family], [SYNTHETIC_NOISE], frames=wanted, seed=options.seed
        )
    ]
    if options.dataset is not None:
        name = options.dataset.resolve().name
        frames += [
            KindFrame(source.name, name, name, partial(_judged_labelled, source))
            for source in open_dataset(options.dataset, DatasetOptions(labels=options.labels))
        ]
    if options.points is not None:
        frames += [
            KindFrame(found.name, kind, kind, partial(_judged_points, found))
            for kind, members in frames_by_camera(read_point_frames(options.points)).items()
            for found in members
        ]
    return _selected(frames, options)


def score_by_kind(frames: Sequence[KindFrame], scores: Sequence[Score]) -> dict[str, float]:
    """Return the share right of each kind, 0-1, worst kind first."""
    by_kind: dict[str, list[Score]] = {}
    for frame, score in zip(frames, scores, strict=True):
        by_kind.setdefault(frame.kind, []).append(score)
    shares = {
        kind: sum(s.right for s in own) / sum(s.total for s in own) for kind, own in by_kind.items()
    }
    return dict(sorted(shares.items(), key=lambda item: item[1]))


def worst_kinds_mean(by_kind: Mapping[str, float]) -> float:
    """Return the mean score of the three worst kinds."""
    return float(np.mean(sorted(by_kind.values())[:WORST_KINDS]))


def _judged_labelled(source: FrameSource) -> JudgedFrame:
    labelled = source.load()
    unscored = labelled.unscored()

    def judge(labels: NDArray[np.int32]) -> Score:
        return Score(score_segmentation(labels, labelled.truth, unscored).f, 1)

    return JudgedFrame(labelled.frame, judge, np.where(labelled.truth > 0, labelled.truth, -1))


def _judged_points(found: PointFrame) -> JudgedFrame:
    truth = np.zeros(found.frame.depth.shape, np.int32)
    truth[found.background[:, 1], found.background[:, 0]] = -1
    for number, points in enumerate(found.objects.values(), start=1):
        truth[points[:, 1], points[:, 0]] = number

    def judge(labels: NDArray[np.int32]) -> Score:
        return Score(score_points(labels, found).count("right"), len(found.objects))

    return JudgedFrame(found.frame, judge, truth)


def _selected(frames: list[KindFrame], options: KindOptions) -> list[KindFrame]:
    """Keep the wanted kinds, and an even spread of frames of each."""
    names = dict.fromkeys(frame.kind for frame in frames)
    for kind in options.kinds:
        if kind not in names:
            known = ", ".join(dict.fromkeys((*FAMILIES, *names)))
            raise InputError(f"--kinds {kind}: no such kind, expected {known}")
    chosen = []
    for kind in options.kinds or names:
        members = [frame for frame in frames if frame.kind == kind]
        count = min(options.frames or len(members), len(members))
        places = np.linspace(0, len(members) - 1, count).round().astype(int)
        chosen += [members[place] for place in places]
    return chosen
