"""Tests of changes that must not alter a segmentation.

These are mirroring, rotation, scale, small noise and memory layout. The frames are synthetic
tabletops at full size, exact or with realistic noise, and a few real frames where available.
Objects are compared up to renumbering.
"""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment
from scipy.spatial.transform import RigidTransform, Rotation

from eyehand.data_synth import DepthNoise, Family, TabletopOptions, make_scene, render_frame
from eyehand.perception import (
    CameraIntrinsics,
    DepthFrame,
    Segmentation,
    SegmentationOptions,
    segment,
)

SEPARATED: tuple[tuple[Family, int, bool], ...] = (
    ("separate", 602, False),
    ("separate", 602, True),
    ("separate", 603, True),
    ("dropped", 600, False),
    ("dropped", 601, True),
)
"""Scenes of objects without contact: family, seed, and whether the depth is noisy."""
IN_CONTACT: tuple[tuple[Family, int, bool], ...] = (
    ("touching", 600, False),
    ("touching", 601, False),
    ("stacked", 603, False),
    ("piled", 601, False),
)
"""Scenes of objects in contact. Their borders depend on thresholds, so the depth is exact."""
EMPTY = ("empty", 0, True)
MIRRORED = (np.s_[:, ::-1], True, False)
ROTATED = (np.s_[::-1, ::-1], True, True)
"""Image index, and whether it reverses the columns and the rows."""
REAL_FRAMES = ("learn0", "learn2", "learn5")

MAX_MIRROR_CHANGE = 0.02
"""Maximum share of object pixels that change labels when mirrored. All lie at borders."""
MAX_NOISE_CHANGE = 0.01
"""Maximum share of object pixels that change labels under a tenth of the frame's noise."""
ADDED_NOISE_SHARE = 0.099
"""Added noise as a share of the frame's noise: just below a tenth."""


@cache
def rendered_frame(family: str, seed: int, noisy: bool) -> DepthFrame:
    """Render a random scene with colour and camera pose."""
    options = TabletopOptions(count_range=(0, 0))
    if family != "empty":
        options = TabletopOptions(family=family, count_range=(4, 7))  # type: ignore[arg-type]  # EMPTY is no family
    noise = DepthNoise.realistic() if noisy else DepthNoise.none()
    return render_frame(make_scene(seed, options), noise, seed)[0]


def without_pose(frame: DepthFrame, *, colour: bool = False) -> DepthFrame:
    return DepthFrame(frame.depth, frame.intrinsics, None, frame.colour if colour else None)


@cache
def segmented(family: str, seed: int, noisy: bool, *, colour: bool = False) -> Segmentation:
    return segment(without_pose(rendered_frame(family, seed, noisy), colour=colour))


def transformed(frame: DepthFrame, transform: tuple) -> DepthFrame:
    """Return the frame mirrored or upside down, with matching intrinsics."""
    index, columns, rows = transform
    k = frame.intrinsics
    camera = replace(
        k,
        cx=k.width - 1 - k.cx if columns else k.cx,
        cy=k.height - 1 - k.cy if rows else k.cy,
    )
    colour = None if frame.colour is None else frame.colour[index]
    return DepthFrame(frame.depth[index], camera, None, colour)


def halved(frame: DepthFrame) -> DepthFrame:
    """Return every second row and column; pixel (0, 0) keeps its position."""
    k = frame.intrinsics
    camera = CameraIntrinsics(k.fx / 2, k.fy / 2, k.cx / 2, k.cy / 2, k.width // 2, k.height // 2)
    return DepthFrame(frame.depth[::2, ::2], camera)


def with_noise(frame: DepthFrame, sigma: float, seed: int) -> DepthFrame:
    """Add noise of `sigma` (1/m) to the disparity, independent of distance."""
    q = np.divide(1.0, frame.depth, out=np.zeros(frame.depth.shape), where=frame.valid)
    q += np.random.default_rng(seed).normal(size=q.shape) * sigma
    depth = np.divide(1.0, q, out=np.zeros_like(q), where=frame.valid)
    return DepthFrame(depth.astype(np.float32), frame.intrinsics)


def shared_pixels(first: NDArray[np.int32], other: NDArray[np.int32]) -> NDArray[np.int64]:
    """Return the number of pixels per pair of labels of two images, (n + 1, m + 1)."""
    table = np.zeros((first.max() + 1, other.max() + 1), np.int64)
    np.add.at(table, (first.ravel(), other.ravel()), 1)
    return table


def changed_share(first: NDArray[np.int32], other: NDArray[np.int32]) -> float:
    """Return the share of object pixels that change labels under the best renumbering."""
    table = shared_pixels(first, other)
    pairs = linear_sum_assignment(-table[1:, 1:])
    same = table[0, 0] + table[1:, 1:][pairs].sum()
    return float((first.size - same) / max(first.size - table[0, 0], 1))


def min_f_score(first: NDArray[np.int32], other: NDArray[np.int32]) -> float:
    """Return the smallest F score of an object of one image with its match in the other."""
    table = shared_pixels(first, other)
    rows, columns = linear_sum_assignment(-table[1:, 1:])
    hits = table[1:, 1:][rows, columns]
    sizes = table[1:].sum(axis=1)[rows] + table[:, 1:].sum(axis=0)[columns]
    return float((2 * hits / sizes).min(initial=1.0))


def real_frame(folder: Path, name: str) -> DepthFrame:
    with np.load(folder / "mosd_learn" / f"{name}.npz") as stored:
        depth = stored["depth"].astype(np.float32) * np.float32(1e-4)
    return DepthFrame(depth, CameraIntrinsics(525.0, 525.0, 319.5, 239.5, 640, 480))


@pytest.mark.parametrize("view", [*SEPARATED, *IN_CONTACT, EMPTY], ids=str)
@pytest.mark.parametrize("transform", [MIRRORED, ROTATED], ids=["mirrored", "upside_down"])
def test_mirrored_or_rotated_image_gives_same_objects(view: tuple, transform: tuple):
    segmentation = segmented(*view)
    other = segment(transformed(without_pose(rendered_frame(*view)), transform))
    assert other.count == segmentation.count
    assert changed_share(segmentation.labels, other.labels[transform[0]]) <= MAX_MIRROR_CHANGE
    assert segmentation.support is not None
    assert other.support is not None
    assert other.support.offset == pytest.approx(segmentation.support.offset, abs=2e-3)


@pytest.mark.parametrize("view", SEPARATED[:2], ids=str)
def test_mirrored_colour_image_gives_same_objects(view: tuple):
    segmentation = segmented(*view, colour=True)
    other = segment(transformed(without_pose(rendered_frame(*view), colour=True), MIRRORED))
    assert other.count == segmentation.count
    assert changed_share(segmentation.labels, other.labels[MIRRORED[0]]) <= MAX_MIRROR_CHANGE


@pytest.mark.parametrize("name", REAL_FRAMES)
@pytest.mark.parametrize("transform", [MIRRORED, ROTATED], ids=["mirrored", "upside_down"])
def test_mirrored_or_rotated_real_image_gives_same_objects(
    real_data: Path, name: str, transform: tuple
):
    frame = real_frame(real_data, name)
    segmentation, other = segment(frame), segment(transformed(frame, transform))
    assert other.count == segmentation.count
    assert changed_share(segmentation.labels, other.labels[transform[0]]) <= MAX_MIRROR_CHANGE


@pytest.mark.parametrize("view", SEPARATED, ids=str)
def test_upside_down_camera_with_pose_gives_same_objects(view: tuple):
    """The camera pose includes the rotation, and gravity still selects the support."""
    frame = rendered_frame(*view)
    assert frame.T_world_camera is not None
    half_turn = RigidTransform.from_rotation(Rotation.from_rotvec([0.0, 0.0, np.pi]))
    upside_down = replace(
        transformed(without_pose(frame), ROTATED), T_world_camera=frame.T_world_camera * half_turn
    )
    segmentation, other = segment(replace(frame, colour=None)), segment(upside_down)
    assert other.count == segmentation.count
    assert changed_share(segmentation.labels, other.labels[ROTATED[0]]) <= MAX_MIRROR_CHANGE


@given(which=st.sampled_from([*SEPARATED, EMPTY]), seed=st.integers(0, 2**32 - 1))
@settings(max_examples=20)
def test_small_noise_changes_few_pixels(which: tuple, seed: int):
    segmentation = segmented(*which)
    frame = with_noise(
        without_pose(rendered_frame(*which)), ADDED_NOISE_SHARE * segmentation.noise, seed
    )
    other = segment(frame)
    assert other.count == segmentation.count
    assert changed_share(segmentation.labels, other.labels) <= MAX_NOISE_CHANGE


@pytest.mark.parametrize("seed", range(2))
@pytest.mark.parametrize("name", REAL_FRAMES)
def test_small_noise_changes_few_pixels_of_real_frames(real_data: Path, name: str, seed: int):
    frame = real_frame(real_data, name)
    segmentation = segment(frame)
    other = segment(with_noise(frame, ADDED_NOISE_SHARE * segmentation.noise, seed))
    assert other.count == segmentation.count
    assert changed_share(segmentation.labels, other.labels) <= MAX_NOISE_CHANGE


@pytest.mark.parametrize("view", [*SEPARATED, EMPTY], ids=str)
def test_half_resolution_gives_same_objects(view: tuple):
    segmentation = segmented(*view)
    other = segment(halved(without_pose(rendered_frame(*view))))
    assert other.count == segmentation.count
    assert min_f_score(segmentation.labels[::2, ::2], other.labels) > 0.9


def fortran(image: NDArray) -> NDArray:
    return np.asfortranarray(image)


def strided(image: NDArray) -> NDArray:
    """Return a view of every second pixel of a larger image, with reversed rows."""
    wide = np.zeros((image.shape[0], 2 * image.shape[1], *image.shape[2:]), image.dtype)
    wide[::-1, ::2] = image
    return wide[::-1, ::2]


def double(image: NDArray) -> NDArray:
    return image.astype(np.float64) if image.dtype == np.float32 else image


def big_endian(image: NDArray) -> NDArray:
    return image.astype(image.dtype.newbyteorder(">")) if image.dtype == np.float32 else image


@pytest.mark.parametrize("change_layout", [fortran, strided, double, big_endian])
@pytest.mark.parametrize("colour", [False, True])
def test_memory_layout_does_not_change_result(change_layout, colour: bool):
    view = IN_CONTACT[-1]
    frame = without_pose(rendered_frame(*view), colour=colour)
    image = None if frame.colour is None else change_layout(frame.colour)
    other = segment(DepthFrame(change_layout(frame.depth), frame.intrinsics, None, image))
    assert_equal(segmented(*view, colour=colour), other)


@pytest.mark.parametrize(
    "options",
    [
        SegmentationOptions(),
        SegmentationOptions(median=False),
        SegmentationOptions(stride=2),
        SegmentationOptions(threads=2),
    ],
    ids=["default", "no_median", "stride_2", "two_threads"],
)
def test_inputs_are_unchanged_and_second_call_is_identical(options: SegmentationOptions):
    frame = rendered_frame(*IN_CONTACT[0])
    assert frame.colour is not None
    # Writable arrays: a frame has read-only views, but their base arrays stay writable.
    depth, colour = frame.depth.copy(), frame.colour.copy()
    frame_copy = DepthFrame(depth, frame.intrinsics, frame.T_world_camera, colour)
    first = segment(frame_copy, options)
    labels = first.labels.copy()
    second = segment(frame_copy, options)
    assert_equal(first, second)
    assert np.array_equal(first.labels, labels)
    assert not np.shares_memory(first.labels, second.labels)
    assert depth.tobytes() == frame.depth.tobytes()
    assert colour.tobytes() == frame.colour.tobytes()


@pytest.mark.parametrize("view", [SEPARATED[1], IN_CONTACT[0]], ids=str)
def test_two_threads_give_identical_result(view: tuple):
    assert_equal(
        segmented(*view),
        segment(without_pose(rendered_frame(*view)), SegmentationOptions(threads=2)),
    )


@given(
    which=st.sampled_from([SEPARATED[1], IN_CONTACT[0]]),
    yaw=st.floats(-np.pi, np.pi),
    translation=st.tuples(*[st.floats(-5.0, 5.0)] * 3),
)
@settings(max_examples=15)
def test_world_origin_and_yaw_do_not_change_result(which: tuple, yaw: float, translation: tuple):
    frame = replace(rendered_frame(*which), colour=None)
    assert frame.T_world_camera is not None
    world = RigidTransform.from_components(translation, Rotation.from_rotvec([0.0, 0.0, yaw]))
    other = segment(replace(frame, T_world_camera=world * frame.T_world_camera))
    assert_equal(segmented_with_pose(which), other)


@given(yaw=st.floats(-np.pi, np.pi), translation=st.tuples(*[st.floats(-5.0, 5.0)] * 2))
@settings(max_examples=10)
def test_world_yaw_does_not_change_result_with_known_table_height(yaw: float, translation: tuple):
    options = SegmentationOptions(table_height=0.0)
    frame = replace(rendered_frame(*SEPARATED[0]), colour=None)
    assert frame.T_world_camera is not None
    world = RigidTransform.from_components(
        (*translation, 0.0), Rotation.from_rotvec([0.0, 0.0, yaw])
    )
    other = segment(replace(frame, T_world_camera=world * frame.T_world_camera), options)
    assert other.count > 0
    assert_equal(segment(frame, options), other)


@cache
def segmented_with_pose(view: tuple) -> Segmentation:
    return segment(replace(rendered_frame(*view), colour=None))


def assert_equal(first: Segmentation, other: Segmentation) -> None:
    """Assert that two results are bitwise equal, except for the times."""
    assert np.array_equal(first.labels, other.labels)
    assert first.labels.dtype == other.labels.dtype == np.int32
    assert first.noise == other.noise
    assert first.ambiguous == other.ambiguous
    planes = [(s.support, *s.other_supports) for s in (first, other)]
    assert len(planes[0]) == len(planes[1])
    for frame_copy, their_plane in zip(*planes, strict=True):
        assert (frame_copy is None) == (their_plane is None)
        if frame_copy is not None and their_plane is not None:
            assert frame_copy.normal.tobytes() == their_plane.normal.tobytes()
            assert (frame_copy.offset, frame_copy.tolerance) == (
                their_plane.offset,
                their_plane.tolerance,
            )
