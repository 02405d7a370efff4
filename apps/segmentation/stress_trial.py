"""One trial of a segmentation on a frame with known truth."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from eyehand.data_synth.render import StagedScene, noise_at_one_metre, staged_frame

from ..bench import Trial
from .score import score_segmentation

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from eyehand.data_synth import DepthNoise
    from eyehand.perception import DepthFrame, Segmentation

BASE_NOISE = noise_at_one_metre(0.001)
"""Noise in the sweeps that do not vary it: 1 mm at 1 m, typical of a good
structured-light camera."""
MAX_SECONDS = 5.0
"""Maximum time of a run, s. A slower segmentation is an invalid answer, because the robot would
wait."""

SegmentCallable = Callable[["DepthFrame"], "Segmentation"]
"""A segmentation under test: depth frame → labels."""


@dataclass(frozen=True)
class TrialPicture:
    """Input, truth and answer of a trial, for a picture."""

    frame: DepthFrame
    """The frame."""
    labels: NDArray[np.int32]
    """Predicted labels, (H, W)."""
    truth: NDArray[np.int32]
    """True labels, (H, W)."""
    scene: StagedScene | None = None
    """Scene whose colours are shown. None shows the frame itself: it was not staged, or its noise
    or dropout is not the default."""


def try_scene(
    method: SegmentCallable,
    scene: StagedScene,
    seed: int,
    noise: DepthNoise = BASE_NOISE,
    *,
    colour: bool = False,
    ambiguous: bool = False,
    dropout: float = 0.0,
) -> Trial:
    """Segment a staged scene. The answer is right if it has every object (F > 0.75) and no other.

    Parameters
    ----------
    method
        Segmentation under test.
    scene
        The scene.
    seed
        Seed of the noise.
    noise
        The camera's errors.
    colour
        Whether the frame has colour.
    ambiguous
        Whether an answer with too few segments is also right, if it marks a segment as ambiguous.
    dropout
        Probability that a pixel loses its reading.
    """
    frame, truth = staged_frame(scene, noise, seed, colour=colour)
    if dropout > 0:
        frame = _thinned(frame, dropout, np.random.default_rng([seed, 1]))
    # Colours would hide the depth errors, so the picture of a noisy frame shows its depth.
    shown = scene if noise is BASE_NOISE and not dropout else None
    return try_frame(method, frame, truth, scene=shown, ambiguous=ambiguous)


def try_frame(
    method: SegmentCallable,
    frame: DepthFrame,
    truth: NDArray[np.int32],
    *,
    scene: StagedScene | None = None,
    ambiguous: bool = False,
) -> Trial:
    """Segment a frame. The answer is right by the same rules as in :func:`try_scene`."""
    found, seconds, fault = timed_segment(method, frame)
    picture = TrialPicture(frame, found.labels, truth, scene)
    if fault:
        return Trial(False, fault, clean=False, seconds=seconds, picture=picture)
    score = score_segmentation(found.labels, truth, ignore=~frame.valid)
    exact = score.found == 1.0 and score.predicted_count == score.truth_count
    warned = ambiguous and bool(found.ambiguous) and score.predicted_count < score.truth_count
    note = ""
    if not exact and not warned:
        kinds = {
            "split": score.over,
            "merged": score.under,
            "missed": score.missed,
            "false": score.false,
        }
        mistakes = [f"{count} {kind}" for kind, count in kinds.items() if count]
        inaccurate = round(score.truth_count * (1 - score.found))
        note = f"{score.predicted_count} segments for {score.truth_count} objects: " + (
            ", ".join(mistakes) or f"{inaccurate} with F of 0.75 or less"
        )
    return Trial(exact or warned, note, score=score.f, seconds=seconds, picture=picture)


def timed_segment(method: SegmentCallable, frame: DepthFrame) -> tuple[Segmentation, float, str]:
    """Segment a frame; return the result, the time in s, and the fault (empty if valid).

    A run longer than MAX_SECONDS is repeated, and the second run counts.
    """
    found, seconds = _timed(method, frame)
    if seconds > MAX_SECONDS:
        # The first run may have spent its time on the compilation of a kernel.
        found, seconds = _timed(method, frame)
    return found, seconds, _fault(found, frame, seconds)


def _timed(method: SegmentCallable, frame: DepthFrame) -> tuple[Segmentation, float]:
    began = time.perf_counter()
    found = method(frame)
    return found, time.perf_counter() - began


def _fault(found: Segmentation, frame: DepthFrame, seconds: float) -> str:
    labels = found.labels
    if seconds > MAX_SECONDS:
        return f"took {seconds:.1f} s"
    if labels.shape != frame.depth.shape or labels.dtype != np.int32:
        return f"labels are {labels.shape} {labels.dtype}"
    sizes = np.bincount(labels.ravel())[1:] if labels.min() >= 0 else np.zeros(1)
    if np.any(sizes == 0) or np.any(np.diff(sizes) > 0):
        return "labels are not 1..n, largest first"
    numbers = [found.noise, *found.timings.values()]
    if found.support is not None:
        numbers += [*found.support.normal, found.support.offset, found.support.tolerance]
    if not np.all(np.isfinite(numbers)):
        return "noise, times or support plane hold NaN"
    return ""


def _thinned(frame: DepthFrame, share: float, rng: np.random.Generator) -> DepthFrame:
    lost = rng.random(frame.depth.shape, np.float32) < share
    return replace(frame, depth=np.where(lost, np.float32(0), frame.depth))
