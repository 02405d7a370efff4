"""What must not matter to a segmentation: mirrors, turns, size, a breath of noise, memory layout.

Frames are synthetic tabletops at the camera's own size, exact or with realistic noise, and a few
real ones where they are at hand. Objects are compared up to renumbering.
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

APART: tuple[tuple[Family, int, bool], ...] = (
    ("separate", 602, False),
    ("separate", 602, True),
    ("separate", 603, True),
    ("dropped", 600, False),
    ("dropped", 601, True),
)
"""Family, seed and whether the camera is noisy: objects that do not touch each other."""
CLOSE: tuple[tuple[Family, int, bool], ...] = (
    ("touching", 600, False),
    ("touching", 601, False),
    ("stacked", 603, False),
    ("piled", 601, False),
)
"""Objects in contact, whose parting lines are a matter of thresholds: exact depth only."""
EMPTY = ("empty", 0, True)
MIRROR = (np.s_[:, ::-1], True, False)
TURN = (np.s_[::-1, ::-1], True, True)
"""How an image is turned, and whether that turns its columns and its rows around."""
REAL = ("learn0", "learn2", "learn5")

BORDER_SHARE = 0.02
"""Share of the objects' pixels, all of them at borders, that may change hands in a mirror."""
NOISE_SHARE = 0.01
"""The same under noise that is a tenth of the frame's own."""
LEAST_NOISE = 0.099
"""That tenth, just below it."""


@cache
def seen(family: str, seed: int, noisy: bool) -> DepthFrame:
    """View of a random scene, with colour and the camera's place."""
    options = TabletopOptions(count_range=(0, 0))
    if family != "empty":
        options = TabletopOptions(family=family, count_range=(4, 7))  # type: ignore[arg-type]  # EMPTY is no family
    noise = DepthNoise.realistic() if noisy else DepthNoise.none()
    return render_frame(make_scene(seed, options), noise, seed)[0]


def without_place(frame: DepthFrame, *, colour: bool = False) -> DepthFrame:
    return DepthFrame(frame.depth, frame.intrinsics, None, frame.colour if colour else None)


@cache
def found(family: str, seed: int, noisy: bool, *, colour: bool = False) -> Segmentation:
    return segment(without_place(seen(family, seed, noisy), colour=colour))


def turned(frame: DepthFrame, turn: tuple) -> DepthFrame:
    """The same view by a camera whose image is mirrored or upside down."""
    places, columns, rows = turn
    k = frame.intrinsics
    camera = replace(
        k,
        cx=k.width - 1 - k.cx if columns else k.cx,
        cy=k.height - 1 - k.cy if rows else k.cy,
    )
    colour = None if frame.colour is None else frame.colour[places]
    return DepthFrame(frame.depth[places], camera, None, colour)


def halved(frame: DepthFrame) -> DepthFrame:
    """Every second row and column: pixel (0, 0) stays where it is."""
    k = frame.intrinsics
    camera = CameraIntrinsics(k.fx / 2, k.fy / 2, k.cx / 2, k.cy / 2, k.width // 2, k.height // 2)
    return DepthFrame(frame.depth[::2, ::2], camera)


def breathed_on(frame: DepthFrame, sigma: float, seed: int) -> DepthFrame:
    """Noise of `sigma` (1/m) on disparity: what a camera adds does not depend on distance."""
    q = np.divide(1.0, frame.depth, out=np.zeros(frame.depth.shape), where=frame.valid)
    q += np.random.default_rng(seed).normal(size=q.shape) * sigma
    depth = np.divide(1.0, q, out=np.zeros_like(q), where=frame.valid)
    return DepthFrame(depth.astype(np.float32), frame.intrinsics)


def shared(one: NDArray[np.int32], other: NDArray[np.int32]) -> NDArray[np.int64]:
    """Pixels by label in one image and in the other, (n + 1, m + 1)."""
    table = np.zeros((one.max() + 1, other.max() + 1), np.int64)
    np.add.at(table, (one.ravel(), other.ravel()), 1)
    return table


def changed_share(one: NDArray[np.int32], other: NDArray[np.int32]) -> float:
    """Share of the objects' pixels that change hands under the best renumbering."""
    table = shared(one, other)
    pairs = linear_sum_assignment(-table[1:, 1:])
    same = table[0, 0] + table[1:, 1:][pairs].sum()
    return float((one.size - same) / max(one.size - table[0, 0], 1))


def least_agreement(one: NDArray[np.int32], other: NDArray[np.int32]) -> float:
    """Smallest F of an object of one image with its partner in the other."""
    table = shared(one, other)
    rows, columns = linear_sum_assignment(-table[1:, 1:])
    hits = table[1:, 1:][rows, columns]
    sizes = table[1:].sum(axis=1)[rows] + table[:, 1:].sum(axis=0)[columns]
    return float((2 * hits / sizes).min(initial=1.0))


def real_frame(folder: Path, name: str) -> DepthFrame:
    with np.load(folder / "mosd_learn" / f"{name}.npz") as stored:
        depth = stored["depth"].astype(np.float32) * np.float32(1e-4)
    return DepthFrame(depth, CameraIntrinsics(525.0, 525.0, 319.5, 239.5, 640, 480))


@pytest.mark.parametrize("view", [*APART, *CLOSE, EMPTY], ids=str)
@pytest.mark.parametrize("turn", [MIRROR, TURN], ids=["mirrored", "upside_down"])
def test_a_turned_image_has_the_same_objects_turned(view: tuple, turn: tuple):
    here = found(*view)
    there = segment(turned(without_place(seen(*view)), turn))
    assert there.count == here.count
    assert changed_share(here.labels, there.labels[turn[0]]) <= BORDER_SHARE
    assert here.support is not None
    assert there.support is not None
    assert there.support.offset == pytest.approx(here.support.offset, abs=2e-3)


@pytest.mark.parametrize("view", APART[:2], ids=str)
def test_a_mirrored_image_in_colour_has_the_same_objects_mirrored(view: tuple):
    here = found(*view, colour=True)
    there = segment(turned(without_place(seen(*view), colour=True), MIRROR))
    assert there.count == here.count
    assert changed_share(here.labels, there.labels[MIRROR[0]]) <= BORDER_SHARE


@pytest.mark.parametrize("name", REAL)
@pytest.mark.parametrize("turn", [MIRROR, TURN], ids=["mirrored", "upside_down"])
def test_a_turned_real_image_has_the_same_objects_turned(real_data: Path, name: str, turn: tuple):
    frame = real_frame(real_data, name)
    here, there = segment(frame), segment(turned(frame, turn))
    assert there.count == here.count
    assert changed_share(here.labels, there.labels[turn[0]]) <= BORDER_SHARE


@pytest.mark.parametrize("view", APART, ids=str)
def test_a_camera_known_to_hang_upside_down_sees_the_same(view: tuple):
    """Here the camera's place says so, and gravity still picks the support."""
    frame = seen(*view)
    assert frame.T_world_camera is not None
    over = RigidTransform.from_rotation(Rotation.from_rotvec([0.0, 0.0, np.pi]))
    hung = replace(turned(without_place(frame), TURN), T_world_camera=frame.T_world_camera * over)
    here, there = segment(replace(frame, colour=None)), segment(hung)
    assert there.count == here.count
    assert changed_share(here.labels, there.labels[TURN[0]]) <= BORDER_SHARE


@given(which=st.sampled_from([*APART, EMPTY]), seed=st.integers(0, 2**32 - 1))
@settings(max_examples=20)
def test_a_breath_of_noise_changes_next_to_nothing(which: tuple, seed: int):
    here = found(*which)
    frame = breathed_on(without_place(seen(*which)), LEAST_NOISE * here.noise, seed)
    there = segment(frame)
    assert there.count == here.count
    assert changed_share(here.labels, there.labels) <= NOISE_SHARE


@pytest.mark.parametrize("seed", range(2))
@pytest.mark.parametrize("name", REAL)
def test_a_breath_of_noise_changes_next_to_nothing_in_real_frames(
    real_data: Path, name: str, seed: int
):
    frame = real_frame(real_data, name)
    here = segment(frame)
    there = segment(breathed_on(frame, LEAST_NOISE * here.noise, seed))
    assert there.count == here.count
    assert changed_share(here.labels, there.labels) <= NOISE_SHARE


@pytest.mark.parametrize("view", [*APART, EMPTY], ids=str)
def test_half_the_resolution_shows_the_same_objects(view: tuple):
    here = found(*view)
    there = segment(halved(without_place(seen(*view))))
    assert there.count == here.count
    assert least_agreement(here.labels[::2, ::2], there.labels) > 0.9


def fortran(image: NDArray) -> NDArray:
    return np.asfortranarray(image)


def strided(image: NDArray) -> NDArray:
    """A view of every second pixel of a larger image, its rows running backwards."""
    wide = np.zeros((image.shape[0], 2 * image.shape[1], *image.shape[2:]), image.dtype)
    wide[::-1, ::2] = image
    return wide[::-1, ::2]


def double(image: NDArray) -> NDArray:
    return image.astype(np.float64) if image.dtype == np.float32 else image


def big_endian(image: NDArray) -> NDArray:
    return image.astype(image.dtype.newbyteorder(">")) if image.dtype == np.float32 else image


@pytest.mark.parametrize("lay_out", [fortran, strided, double, big_endian])
@pytest.mark.parametrize("colour", [False, True])
def test_the_memory_layout_of_a_frame_does_not_matter(lay_out, colour: bool):
    view = CLOSE[-1]
    frame = without_place(seen(*view), colour=colour)
    image = None if frame.colour is None else lay_out(frame.colour)
    there = segment(DepthFrame(lay_out(frame.depth), frame.intrinsics, None, image))
    assert_equal(found(*view, colour=colour), there)


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
def test_inputs_are_left_alone_and_a_second_call_gives_the_same_bits(
    options: SegmentationOptions,
):
    frame = seen(*CLOSE[0])
    assert frame.colour is not None
    # Writable arrays: a frame's own views are read-only, what is behind them is not.
    depth, colour = frame.depth.copy(), frame.colour.copy()
    mine = DepthFrame(depth, frame.intrinsics, frame.T_world_camera, colour)
    first = segment(mine, options)
    labels = first.labels.copy()
    second = segment(mine, options)
    assert_equal(first, second)
    assert np.array_equal(first.labels, labels)
    assert not np.shares_memory(first.labels, second.labels)
    assert depth.tobytes() == frame.depth.tobytes()
    assert colour.tobytes() == frame.colour.tobytes()


@pytest.mark.parametrize("view", [APART[1], CLOSE[0]], ids=str)
def test_two_threads_give_the_bits_of_one(view: tuple):
    assert_equal(found(*view), segment(without_place(seen(*view)), SegmentationOptions(threads=2)))


@given(
    which=st.sampled_from([APART[1], CLOSE[0]]),
    yaw=st.floats(-np.pi, np.pi),
    moved=st.tuples(*[st.floats(-5.0, 5.0)] * 3),
)
@settings(max_examples=15)
def test_where_the_world_has_its_origin_and_north_does_not_matter(
    which: tuple, yaw: float, moved: tuple
):
    frame = replace(seen(*which), colour=None)
    assert frame.T_world_camera is not None
    world = RigidTransform.from_components(moved, Rotation.from_rotvec([0.0, 0.0, yaw]))
    there = segment(replace(frame, T_world_camera=world * frame.T_world_camera))
    assert_equal(placed(which), there)


@given(yaw=st.floats(-np.pi, np.pi), moved=st.tuples(*[st.floats(-5.0, 5.0)] * 2))
@settings(max_examples=10)
def test_nor_does_it_where_the_height_of_the_table_is_known(yaw: float, moved: tuple):
    options = SegmentationOptions(table_height=0.0)
    frame = replace(seen(*APART[0]), colour=None)
    assert frame.T_world_camera is not None
    world = RigidTransform.from_components((*moved, 0.0), Rotation.from_rotvec([0.0, 0.0, yaw]))
    there = segment(replace(frame, T_world_camera=world * frame.T_world_camera), options)
    assert there.count > 0
    assert_equal(segment(frame, options), there)


@cache
def placed(view: tuple) -> Segmentation:
    return segment(replace(seen(*view), colour=None))


def assert_equal(one: Segmentation, other: Segmentation) -> None:
    """Equal to the last bit, but for the time it took."""
    assert np.array_equal(one.labels, other.labels)
    assert one.labels.dtype == other.labels.dtype == np.int32
    assert one.noise == other.noise
    assert one.ambiguous == other.ambiguous
    planes = [(s.support, *s.other_supports) for s in (one, other)]
    assert len(planes[0]) == len(planes[1])
    for mine, theirs in zip(*planes, strict=True):
        assert (mine is None) == (theirs is None)
        if mine is not None and theirs is not None:
            assert mine.normal.tobytes() == theirs.normal.tobytes()
            assert (mine.offset, mine.tolerance) == (theirs.offset, theirs.tolerance)
