"""Sweeps in which the input stops being a picture of a table: wrong units, no readings, chaos."""

from __future__ import annotations

import functools

import numpy as np

from eyehand.data_synth.render import staged_frame
from eyehand.errors import InputError
from eyehand.perception import CameraIntrinsics, DepthFrame

from ..bench import Sweep, Trial
from .camera_sweeps import MM, ordinary_scene
from .stress_trial import BASE_NOISE, SegmentCallable, TrialPicture, timed_segment

FOCAL_SHARE = 0.82
"""Focal length over image width of the cameras here."""
TIMES_ORDINARY = 10.0
"""A frame full of clutter may take this many times as long as an ordinary one of its size."""
TABLE_M = 1.0
"""Depth of the plane behind everything here."""
REFERENCE_LOOKS = 3
"""Looks at an ordinary frame, of which the median time counts."""

CLEAN = "no crash, no garbage, no object made up"


def input_sweeps() -> tuple[Sweep[SegmentCallable], ...]:
    """Sweeps of wrong units, missing and impossible readings, tiny images and clutter."""
    return (
        Sweep(
            name="millimetres",
            axis="scene's distance, given in mm as m",
            unit="mm",
            values=(3000, 2000, 1000, 500, 300, 200, 150, 100, 50, 20),
            holds_to=150,
            attempt=_millimetres,
            right="refused, with millimetres as the guess",
            repeats=1,
        ),
        Sweep(
            name="nan",
            axis="pixels that are NaN",
            unit="px",
            values=(1, 100, 10_000, 307_200),
            holds_to=307_200,
            attempt=_nan,
            right="refused, with NaN named",
            repeats=1,
        ),
        Sweep(
            name="readings",
            axis="pixels with a reading",
            unit="px",
            values=(10_000, 1000, 100, 10, 1, 0),
            holds_to=0,
            attempt=_readings,
            right=f"{CLEAN}; none at all is refused",
        ),
        Sweep(
            name="tiny-image",
            axis="side of the image",
            unit="px",
            values=(64, 32, 16, 8, 4, 3, 2, 1),
            holds_to=1,
            attempt=_tiny_image,
            right="no crash, no garbage",
        ),
        Sweep(
            name="tiny-objects",
            axis="objects in one image",
            unit="",
            values=(100, 400, 1000, 2000, 4000, 16_000),
            holds_to=16_000,
            attempt=_tiny_objects,
            right=f"within {TIMES_ORDINARY:g} times an ordinary frame",
        ),
        Sweep(
            name="chaos",
            axis="pixels of random depth",
            unit="%",
            values=(0, 1, 10, 30, 60, 100),
            holds_to=100,
            attempt=_chaos,
            right=f"within {TIMES_ORDINARY:g} times an ordinary frame",
        ),
    )


def _millimetres(distance: float, seed: int, method: SegmentCallable) -> Trial:
    frame, _ = staged_frame(ordinary_scene(seed), BASE_NOISE, seed)
    depth = frame.depth / np.median(frame.depth[frame.valid]) * np.float32(distance)
    return _refused(method, depth, frame.intrinsics, "millimetres")


def _nan(count: float, seed: int, method: SegmentCallable) -> Trial:
    frame, _ = staged_frame(ordinary_scene(seed), BASE_NOISE, seed)
    depth = frame.depth.copy()
    depth.flat[np.random.default_rng(seed).permutation(depth.size)[: int(count)]] = np.nan
    return _refused(method, depth, frame.intrinsics, "NaN")


def _readings(count: float, seed: int, method: SegmentCallable) -> Trial:
    frame, truth = staged_frame(ordinary_scene(seed), BASE_NOISE, seed)
    if count == 0:
        return _refused(method, np.zeros_like(frame.depth), frame.intrinsics, "no reading")
    kept = np.random.default_rng(seed).permutation(frame.depth.size)[: int(count)]
    depth = np.zeros_like(frame.depth)
    depth.flat[kept] = frame.depth.flat[kept]
    few = DepthFrame(depth, frame.intrinsics)
    found, seconds, fault = timed_segment(method, few)
    note = fault or (f"{found.count} objects made up" if found.count else "")
    picture = TrialPicture(few, found.labels, np.where(few.valid, truth, 0).astype(np.int32))
    return Trial(not note, note, clean=not fault, seconds=seconds, picture=picture)


def _tiny_image(side: float, seed: int, method: SegmentCallable) -> Trial:
    size = int(side)
    rng = np.random.default_rng([seed, size])
    depth = np.full((size, size), TABLE_M, np.float32)
    # A block that fills the middle quarter, and noise.
    depth[size // 4 : size - size // 4, size // 4 : size - size // 4] -= np.float32(0.1)
    truth = (depth < TABLE_M).astype(np.int32)
    depth += rng.normal(0, 1 * MM, depth.shape).astype(np.float32)
    frame = DepthFrame(depth, _camera(size, size))
    found, seconds, fault = timed_segment(method, frame)
    return Trial(
        not fault,
        fault,
        clean=not fault,
        seconds=seconds,
        picture=TrialPicture(frame, found.labels, truth),
    )


def _tiny_objects(count: float, seed: int, method: SegmentCallable) -> Trial:
    return _in_time(method, *_studded(int(count), seed))


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
    """Depth straight down on a plane with `count` studs in a grid, and the studs' labels."""
    wide, high = 640, 480
    columns = int(np.ceil(np.sqrt(count * wide / high)))
    rows = -(-count // columns)
    u, v = np.arange(wide) * columns / wide, np.arange(high) * rows / high
    # The middle two thirds of every cell are the stud.
    on_u, on_v = (np.abs(at - np.floor(at) - 0.5) < 1 / 3 for at in (u, v))
    number = np.floor(v).astype(np.int32)[:, None] * columns + np.floor(u).astype(np.int32) + 1
    truth = np.where(on_v[:, None] & on_u & (number <= count), number, 0).astype(np.int32)
    heights = np.random.default_rng(seed).uniform(0.02, 0.1, count + 1)
    heights[0] = 0.0
    clean = TABLE_M - heights[truth]
    noise = np.random.default_rng([seed, count]).normal(0, 1 * MM, clean.shape)
    return DepthFrame((clean + noise).astype(np.float32), _camera(wide, high)), truth


def _in_time(method: SegmentCallable, frame: DepthFrame, truth: np.ndarray) -> Trial:
    # The better of two: a shared machine can stop any one of them.
    found, seconds, fault = timed_segment(method, frame)
    seconds = min(seconds, timed_segment(method, frame)[1])
    times = seconds / _ordinary_seconds(method)
    note = fault
    if not fault and times > TIMES_ORDINARY:
        note = f"took {times:.1f} times as long as an ordinary frame"
    return Trial(
        not note,
        note,
        clean=not fault,
        seconds=seconds,
        picture=TrialPicture(frame, found.labels, truth),
    )


@functools.cache
def _ordinary_seconds(method: SegmentCallable) -> float:
    frame, _ = staged_frame(ordinary_scene(0), BASE_NOISE, 0)
    return float(np.median([timed_segment(method, frame)[1] for _ in range(REFERENCE_LOOKS)]))


def _refused(
    method: SegmentCallable, depth: np.ndarray, camera: CameraIntrinsics, reason: str
) -> Trial:
    """Right is an `InputError` that names the reason."""
    try:
        frame = DepthFrame(depth, camera)
    except InputError as error:
        told = reason in str(error)
        return Trial(told, "" if told else f"refused, but: {error}", clean=told)
    _, seconds, fault = timed_segment(method, frame)
    return Trial(False, fault or "not refused", clean=not fault, seconds=seconds)


def _camera(width: int, height: int) -> CameraIntrinsics:
    focal = FOCAL_SHARE * width
    return CameraIntrinsics(focal, focal, (width - 1) / 2, (height - 1) / 2, width, height)
