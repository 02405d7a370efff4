"""Sweeps of the camera: depth errors, image size, viewing angle, and stability."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial

import numpy as np

from eyehand.data_synth import DepthNoise, Table
from eyehand.data_synth.render import StagedObject, StagedScene, StagedView, noise_at_one_metre
from eyehand.data_synth.scenes import staged_solids as shapes

from ..bench import Sweep, Trial, as_sweep
from .self_agreement import disturbed_frame, self_agreement
from .stress_trial import BASE_NOISE, SegmentCallable, TrialPicture, timed_segment, try_scene
from .synthetic_frames import EMPTY_FAMILIES, FAMILIES, synthetic_sources

COLOURS = (
    (0.72, 0.24, 0.20),
    (0.20, 0.42, 0.68),
    (0.26, 0.58, 0.34),
    (0.85, 0.65, 0.20),
    (0.55, 0.33, 0.60),
)
"""Colours of the objects of a scene, in this order."""
IMAGE_HEIGHTS = {1280: 720, 960: 540}
"""Image width → height of the wide image formats, px. All others are 4:3."""
NOISE_DRAWS = 10
"""Number of frames of the same scene, each with other noise."""
MM = 1e-3
"""One millimetre, m."""

finds_all_five = partial(as_sweep, right="exactly the 5 separate objects found")


def ordinary_scene(seed: int) -> StagedScene:
    """Return five separate objects of different shapes. None hides another."""
    rng = np.random.default_rng([seed, 5])
    solids: list[shapes.StagedSolid] = [
        shapes.box(*rng.uniform(0.045, 0.09, 3)),
        shapes.cylinder(rng.uniform(0.025, 0.045), rng.uniform(0.05, 0.1)),
        shapes.ball(rng.uniform(0.025, 0.045)),
        shapes.superquadric(
            (rng.uniform(0.05, 0.09), rng.uniform(0.05, 0.09), rng.uniform(0.05, 0.09)),
            (rng.uniform(0.3, 1.0), rng.uniform(0.3, 1.0)),
        ),
        shapes.tapered_box((0.08, 0.06), (rng.uniform(0.03, 0.06), 0.04), rng.uniform(0.05, 0.09)),
    ]
    places = [(-0.17, -0.1), (0.0, -0.12), (0.17, -0.1), (-0.1, 0.12), (0.1, 0.12)]
    order = rng.permutation(len(solids))
    objects = tuple(
        StagedObject(
            solids[k],
            (x + rng.uniform(-0.01, 0.01), y + rng.uniform(-0.01, 0.01), 0.0),
            yaw=rng.uniform(0, 2 * np.pi),
            colour=COLOURS[number],
        )
        for number, (k, (x, y)) in enumerate(zip(order, places, strict=True))
    )
    return StagedScene(objects, view_around(rng))


def view_around(
    rng: np.random.Generator,
    elevation: tuple[float, float] = (42, 52),
    distance: tuple[float, float] = (0.75, 0.9),
    turn: float = 15.0,
    target: tuple[float, float, float] = (0.0, 0.0, 0.03),
) -> StagedView:
    """Draw a random view from the -y side.

    Parameters
    ----------
    rng
        Random numbers.
    elevation
        Range of the camera's elevation, degrees.
    distance
        Range of the distance to the target, m.
    turn
        Maximum turn of the camera to the left or right, degrees.
    target
        Point at the image centre, m.
    """
    return StagedView(
        elevation=np.radians(rng.uniform(*elevation)),
        azimuth=-np.pi / 2 + np.radians(rng.uniform(-turn, turn)),
        distance=rng.uniform(*distance),
        target=target,
    )


@finds_all_five(
    "noise", "noise of each pixel at 1 m", "mm", (0, 1, 2, 3, 5, 8, 12, 16, 24), holds_to=8
)
def _noise(sigma: float, seed: int, method: SegmentCallable) -> Trial:
    return try_scene(method, ordinary_scene(seed), seed, noise_at_one_metre(sigma * MM))


@finds_all_five(
    "kinect", "Kinect depth errors, factor", "", (0, 0.5, 1, 1.5, 2, 3, 4, 6), holds_to=2
)
def _kinect(scale: float, seed: int, method: SegmentCallable) -> Trial:
    return try_scene(method, ordinary_scene(seed), seed, DepthNoise.realistic(scale))


@finds_all_five(
    "dropout", "single pixels lost", "%", (0, 10, 20, 30, 40, 50, 60, 70, 80), holds_to=20
)
def _dropout(share: float, seed: int, method: SegmentCallable) -> Trial:
    return try_scene(method, ordinary_scene(seed), seed, dropout=share / 100)


@finds_all_five("holes", "area lost in blotches", "%", (0, 5, 10, 20, 30, 40, 60, 80), holds_to=20)
def _holes(share: float, seed: int, method: SegmentCallable) -> Trial:
    noise = replace(BASE_NOISE, hole_share=share / 100)
    return try_scene(method, ordinary_scene(seed), seed, noise)


@finds_all_five(
    "image-size", "image width", "px", (1280, 960, 640, 480, 320, 240, 160, 80, 40), holds_to=320
)
def _image_size(width: float, seed: int, method: SegmentCallable) -> Trial:
    scene = ordinary_scene(seed)
    size = (int(width), IMAGE_HEIGHTS.get(int(width), int(width) * 3 // 4))
    return try_scene(method, replace(scene, view=replace(scene.view, image_size=size)), seed)


@as_sweep(
    "grazing",
    "camera elevation",
    "°",
    (60, 45, 30, 20, 15, 10, 7, 5),
    holds_to=10,
    right="exactly the 3 objects side by side found",
)
def _grazing(elevation: float, seed: int, method: SegmentCallable) -> Trial:
    rng = np.random.default_rng([seed, 3])
    solids = [
        shapes.box(0.07, 0.05, rng.uniform(0.04, 0.1)),
        shapes.cylinder(0.035, 0.08),
        shapes.ball(0.035),
    ]
    objects = tuple(
        StagedObject(solids[k], (x, rng.uniform(-0.02, 0.02), 0.0), yaw, colour=COLOURS[k])
        for k, x, yaw in zip(
            rng.permutation(3), (-0.15, 0.0, 0.15), rng.uniform(0, np.pi, 3), strict=True
        )
    )
    view = replace(view_around(rng, turn=8.0), elevation=np.radians(elevation))
    return try_scene(method, StagedScene(objects, view), seed)


@as_sweep(
    "empty",
    "noise at 1 m, on an empty table",
    "mm",
    (0, 1, 2, 3, 4, 5, 7, 10, 15),
    holds_to=10,
    right="no object found",
)
def _empty(sigma: float, seed: int, method: SegmentCallable) -> Trial:
    rng = np.random.default_rng([seed, 7])
    view = view_around(rng, elevation=(25, 65), distance=(0.6, 1.1), turn=180.0)
    # In every second scene the table ends inside the image, and the floor is visible.
    table = Table(size=(0.7, 0.5) if seed % 2 else (1.6, 1.6))
    return try_scene(method, StagedScene((), view, table), seed, noise_at_one_metre(sigma * MM))


@as_sweep(
    "repeat",
    f"noise at 1 m, {NOISE_DRAWS} frames per scene",
    "mm",
    (0, 1, 2, 3, 5, 8, 12, 16),
    holds_to=8,
    right=f"5 objects in each of {NOISE_DRAWS} frames",
    repeats=3,
)
def _repeat(sigma: float, seed: int, method: SegmentCallable) -> Trial:
    scene = ordinary_scene(seed)
    trials = [
        try_scene(method, scene, NOISE_DRAWS * seed + draw, noise_at_one_metre(sigma * MM))
        for draw in range(NOISE_DRAWS)
    ]
    wrong = [trial for trial in trials if not trial.passed]
    if not wrong:
        return trials[0]
    note = f"{len(wrong)} of {len(trials)} frames are wrong; {wrong[0].note}"
    return replace(wrong[0], note=note, clean=all(trial.clean for trial in trials))


CAMERA_SWEEPS = (_noise, _kinect, _dropout, _holes, _image_size, _grazing, _empty, _repeat)
"""Sweeps of depth errors, image size and viewing angle."""


SHARES = (0.1, 0.2, 0.5, 1.0, 2.0, 5.0)
"""Shares of the readings that move, %."""
HOLDS_TO = 0.5
"""Share up to which the segmentation must agree with itself, %."""
MIN_AGREEMENT = 0.95
"""Minimum share of the labelled pixels that keep their object."""


def _agreement_sweep(family: str) -> Sweep[SegmentCallable]:
    return Sweep(
        name=f"agree-{family}",
        axis=f"readings moved by ±1 mm, {family} scenes",
        unit="%",
        values=SHARES,
        holds_to=HOLDS_TO,
        attempt=_attempt(family),
        right=f"{100 * MIN_AGREEMENT:g} % of the labelled pixels keep their object",
    )


def _attempt(family: str) -> Callable[[float, int, SegmentCallable], Trial]:
    def attempt(share: float, seed: int, method: SegmentCallable) -> Trial:
        (source,) = synthetic_sources([family], ["realistic"], frames=1, seed=seed)
        labelled = source.load()
        moved = disturbed_frame(labelled.frame, share / 100, seed)
        before = method(labelled.frame).labels
        found, seconds, fault = timed_segment(method, moved)
        picture = TrialPicture(moved, found.labels, before)
        if fault:
            return Trial(False, fault, clean=False, seconds=seconds, picture=picture)
        agreement = self_agreement(before, found.labels)
        stable = agreement >= MIN_AGREEMENT
        note = "" if stable else f"{100 * agreement:.0f} % keep their object"
        return Trial(stable, note, score=agreement, seconds=seconds, picture=picture)

    return attempt


AGREEMENT_SWEEPS = tuple(
    _agreement_sweep(family) for family in FAMILIES if family not in EMPTY_FAMILIES
)
"""One sweep per family of synthetic scenes."""
