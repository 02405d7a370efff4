"""Sweeps of unusual input: wrong units, missing readings, tiny images, clutter."""

from __future__ import annotations

from functools import cache, partial

import numpy as np

from eyehand.data_synth.render import staged_frame
from eyehand.errors import InputError
from eyehand.perception import CameraIntrinsics, DepthFrame

from ..bench import Trial, as_sweep
from .camera_sweeps import MM, ordinary_scene
from .stress_trial import BASE_NOISE, SegmentCallable, TrialPicture, timed_segment

FOCAL_SHARE = 0.82
"""Focal length of the cameras in this file, as a fraction of the image width."""
MAX_TIME_RATIO = 10.0
"""Maximum run time of a cluttered frame, relative to an ordinary frame of the same size."""
TABLE_M = 1.0
"""Depth of the background plane, m."""
REFERENCE_RUNS = 3
"""Number of runs on an ordinary frame. Their median is the reference time."""

holds_time = partial(as_sweep, right=f"within {MAX_TIME_RATIO:g} times an ordinary frame")


@as_sweep(
    "millimetres",
    "scene distance, mm read as m",
    "mm",
    (3000, 2000, 1000, 500, 300, 200, 150, 100, 50, 20),
    holds_to=150,
    right="rejected; the message suggests millimetres",
    repeats=1,
)
def _millimetres(distance: float, seed: int, method: SegmentCallable) -> Trial:
    frame, _ = staged_frame(ordinary_scene(seed), BASE_NOISE, seed)
    depth = frame.depth / np.median(frame.depth[frame.valid]) * np.float32(distance)
    return _try_rejection(method, depth, frame.intrinsics, "millimetres")


@as_sweep(
    "nan",
    "pixels that are NaN",
    "px",
    (1, 100, 10_000, 307_200),
    holds_to=307_200,
    right="rejected; the message names NaN",
    repeats=1,
)
def _nan(count: float, seed: int, method: SegmentCallable) -> Trial:
    frame, _ = staged_frame(ordinary_scene(seed), BASE_NOISE, seed)
    depth = frame.depth.copy()
    depth.flat[np.random.default_rng(seed).permutation(depth.size)[: int(count)]] = np.nan
    return _try_rejection(method, depth, frame.intrinsics, "NaN")


@as_sweep(
    "readings",
    "pixels with a reading",
    "px",
    (10_000, 1000, 100, 10, 1, 0),
    holds_to=0,
    right="valid answer without objects; rejected without readings",
)
def _readings(count: float, seed: int, method: SegmentCallable) -> Trial:
    frame, truth = staged_frame(ordinary_scene(seed), BASE_NOISE, seed)
    if count == 0:
        return _try_rejection(method, np.zeros_like(frame.depth), frame.intrinsics, "no reading")
    kept = np.random.default_rng(seed).permutation(frame.depth.size)[: int(count)]
    depth = np.zeros_like(frame.depth)
    depth.flat[kept] = frame.depth.flat[kept]
    few = DepthFrame(depth, frame.intrinsics)
    found, seconds, fault = timed_segment(method, few)
    note = fault or (f"{found.count} false objects" if found.count else "")
    picture = TrialPicture(few, found.labels, np.where(few.valid, truth, 0).astype(np.int32))
    return Trial(not note, note, clean=not fault, seconds=seconds, picture=picture)


@as_sweep(
    "tiny-image",
    "side of the image",
    "px",
    (64, 32, 16, 8, 4, 3, 2, 1),
    holds_to=1,
    right="valid answer",
)
def _tiny_image(side: float, seed: int, method: SegmentCallable) -> Trial:
    size = int(side)
    rng = np.random.default_rng([seed, size])
    depth = np.full((size, size), TABLE_M, np.float32)
    # A block in front of the middle quarter of the plane.
    depth[size // 4 : size - size // 4, size // 4 : size - size // 4] -= np.float32(0.1)
    truth = (depth < TABLE_M).astype(np.int32)
    depth += rng.normal(0, 1 * MM, depth.shape).astype(np.float32)
    frame = DepthFrame(depth, _camera(size, size))
    found, seconds, fault = timed_segment(method, frame)
    picture = TrialPicture(frame, found.labels, truth)
    return Trial(not fault, fault, clean=not fault, seconds=seconds, picture=picture)


@holds_time(
    "tiny-objects",
    "objects in one image",
    "",
    (100, 400, 1000, 2000, 4000, 16_000),
    holds_to=16_000,
)
def _tiny_objects(count: float, seed: int, method: SegmentCallable) -> Trial:
    return _in_time(method, *_studded(int(count), seed))


@holds_time("chaos", "pixels of random depth", "%", (0, 1, 10, 30, 60, 100), holds_to=100)
def _chaos(share: float, seed: int, method: SegmentCallable) -> Trial:
    frame, truth = staged_frame(ordinary_scene(seed), BASE_NOISE, seed)
    rng = np.random.default_rng([seed, 71])
    wild = rng.uniform(0.3, 3.0, frame.depth.shape).astype(np.float32)
    hit = rng.random(frame.depth.shape) < share / 100
    depth = np.where(hit, wild, frame.depth)
    return _in_time(
        method, DepthFrame(depth, frame.intrinsics), np.where(hit, 0, truth).astype(np.int32)
    )


def _studded(count: int, seed: int) -> tuple[DepthFrame, np.ndarray]:
    """Return a frame that looks straight down on a grid of `count` studs, and their labels."""
    wide, high = 640, 480
    columns = int(np.ceil(np.sqrt(count * wide / high)))
    rows = -(-count // columns)
    u, v = np.arange(wide) * columns / wide, np.arange(high) * rows / high
    # A stud covers the middle two thirds of its cell in each direction.
    on_u, on_v = (np.abs(at - np.floor(at) - 0.5) < 1 / 3 for at in (u, v))
    number = np.floor(v).astype(np.int32)[:, None] * columns + np.floor(u).astype(np.int32) + 1
    truth = np.where(on_v[:, None] & on_u & (number <= count), number, 0).astype(np.int32)
    heights = np.random.default_rng(seed).uniform(0.02, 0.1, count + 1)
    heights[0] = 0.0
    clean = TABLE_M - heights[truth]
    noise = np.random.default_rng([seed, count]).normal(0, 1 * MM, clean.shape)
    return DepthFrame((clean + noise).astype(np.float32), _camera(wide, high)), truth


def _in_time(method: SegmentCallable, frame: DepthFrame, truth: np.ndarray) -> Trial:
    # The faster of two runs counts: other processes may interrupt one of them.
    found, seconds, fault = timed_segment(method, frame)
    seconds = min(seconds, timed_segment(method, frame)[1])
    times = seconds / _ordinary_seconds(method)
    note = fault
    if not fault and times > MAX_TIME_RATIO:
        note = f"took {times:.1f} times as long as an ordinary frame"
    picture = TrialPicture(frame, found.labels, truth)
    return Trial(not note, note, clean=not fault, seconds=seconds, picture=picture)


@cache
def _ordinary_seconds(method: SegmentCallable) -> float:
    frame, _ = staged_frame(ordinary_scene(0), BASE_NOISE, 0)
    return float(np.median([timed_segment(method, frame)[1] for _ in range(REFERENCE_RUNS)]))


def _try_rejection(
    method: SegmentCallable, depth: np.ndarray, camera: CameraIntrinsics, reason: str
) -> Trial:
    """Pass a depth image that must be rejected with an `InputError` that contains `reason`."""
    try:
        frame = DepthFrame(depth, camera)
    except InputError as error:
        named = reason in str(error)
        return Trial(named, "" if named else f"rejected for another reason: {error}", clean=named)
    _, seconds, fault = timed_segment(method, frame)
    return Trial(False, fault or "not rejected", clean=not fault, seconds=seconds)


def _camera(width: int, height: int) -> CameraIntrinsics:
    focal = FOCAL_SHARE * width
    return CameraIntrinsics(focal, focal, (width - 1) / 2, (height - 1) / 2, width, height)


INPUT_SWEEPS = (_millimetres, _nan, _readings, _tiny_image, _tiny_objects, _chaos)
"""Sweeps of wrong units, missing and impossible readings, tiny images and clutter."""
