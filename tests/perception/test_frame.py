"""Tests of depth frames and camera intrinsics."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from eyehand.errors import InputError
from eyehand.perception import CameraIntrinsics, DepthFrame

CAMERA = CameraIntrinsics(60.0, 62.0, 15.5, 11.5, 32, 24)


def flat_depth(depth: float = 1.0) -> np.ndarray:
    return np.full((24, 32), depth, np.float32)


@given(
    u=st.integers(0, 31),
    v=st.integers(0, 23),
    z=st.floats(0.1, 5.0),
    dtype=st.sampled_from([np.float32, np.float64]),
)
def test_points_project_to_their_pixels(u, v, z, dtype):
    depth: np.ndarray = np.zeros((24, 32), dtype)
    depth[v, u] = z
    points = DepthFrame(depth, CAMERA).points()
    assert np.allclose(CAMERA.project(points[v, u]), [u, v], atol=1e-4)
    assert points[v, u, 2] == np.float32(z)


def test_rays_have_unit_depth_and_pass_through_pixel_centres():
    rays = CAMERA.rays()
    assert np.all(rays[..., 2] == 1.0)
    assert np.allclose(CAMERA.project(rays[5, 7]), [7, 5])


def test_points_behind_camera_have_no_pixel():
    assert np.isnan(CAMERA.project(np.array([0.0, 0.0, -1.0]))).all()


@pytest.mark.parametrize(
    ("depth", "message"),
    [
        (np.ones((24, 31), np.float32), "31x24"),
        (np.ones((24, 32, 1), np.float32), "shape"),
        (np.ones((24, 32), np.uint16), "uint16"),
        (flat_depth(np.nan), "NaN"),
        (flat_depth(np.inf), "infinite"),
        (flat_depth(-1.0), "negative"),
        (flat_depth(0.0), "0 everywhere"),
        (flat_depth(800.0), "millimetres"),
    ],
)
def test_invalid_depth_is_rejected(depth, message):
    with pytest.raises(InputError, match=message):
        DepthFrame(depth, CAMERA)


def test_pose_of_another_type_is_rejected():
    with pytest.raises(InputError, match=r"must be a RigidTransform, .* got ndarray"):
        DepthFrame(flat_depth(), CAMERA, np.eye(4))  # pyright: ignore[reportArgumentType]


def test_colour_of_other_size_is_rejected():
    with pytest.raises(InputError, match="colour"):
        DepthFrame(flat_depth(), CAMERA, colour=np.zeros((10, 10, 3), np.uint8))


@pytest.mark.parametrize(
    "invalid",
    [
        *({"fx": 0.0}, {"fy": -1.0}, {"fx": 1e300}, {"fy": 1e-3}, {"cx": np.nan}, {"cy": 1e300}),
        *({"width": 0}, {"width": 20_000, "height": 20_000}),
    ],
)
def test_invalid_intrinsics_are_rejected(invalid):
    with pytest.raises(InputError):
        CameraIntrinsics(
            **{"fx": 1.0, "fy": 1.0, "cx": 0.0, "cy": 0.0, "width": 1, "height": 1} | invalid
        )


def test_frame_is_read_only_and_input_stays_writable():
    depth = flat_depth()
    frame = DepthFrame(depth, CAMERA)
    with pytest.raises(ValueError, match="read-only"):
        frame.depth[0, 0] = 2.0
    depth[0, 0] = 3.0


@given(stride=st.integers(1, 40))
def test_reduced_camera_has_rays_of_every_nth_pixel(stride):
    reduced = CAMERA.reduced(stride)
    pixels = flat_depth()[::stride, ::stride]
    assert (reduced.height, reduced.width) == pixels.shape
    assert np.allclose(reduced.rays(), CAMERA.rays()[::stride, ::stride])


@given(
    rows=st.tuples(st.integers(0, 23), st.integers(1, 30)),
    columns=st.tuples(st.integers(0, 31), st.integers(1, 40)),
)
def test_cropped_camera_keeps_rays(rows, columns):
    window = slice(rows[0], sum(rows)), slice(columns[0], sum(columns))
    cropped = CAMERA.cropped(*window)
    assert (cropped.height, cropped.width) == flat_depth()[window].shape
    assert np.allclose(cropped.rays(), CAMERA.rays()[window])


def test_crop_accepts_open_and_negative_slices():
    window = slice(None), slice(-10, -2)
    cropped = CAMERA.cropped(*window)
    assert np.allclose(cropped.rays(), CAMERA.rays()[window])
    assert CAMERA.cropped(slice(None), slice(None)) == CAMERA


def test_empty_crop_is_rejected():
    with pytest.raises(InputError, match="image size"):
        CAMERA.cropped(slice(5, 5), slice(None))


def test_reduced_and_cropped_points_match_frame():
    depth = np.random.default_rng(0).uniform(0.5, 2.0, (24, 32)).astype(np.float32)
    window = slice(2, 9), slice(3, 8)
    camera = CAMERA.reduced(3).cropped(*window)
    reduced = DepthFrame(depth[::3, ::3][window], camera)
    whole = DepthFrame(depth, CAMERA).points()
    assert np.allclose(reduced.points(), whole[::3, ::3][window], atol=1e-6)
