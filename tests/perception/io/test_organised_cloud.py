"""Tests of recovering the camera from a cloud with one point per pixel."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from eyehand.errors import InputError
from eyehand.perception import CameraIntrinsics, DepthFrame
from eyehand.perception.io.intrinsics import CameraFile
from eyehand.perception.io.organised_cloud import (
    cloud_from_frame,
    frame_from_cloud,
    recover_intrinsics,
)
from eyehand.perception.io.point_table import PointTable

K = CameraIntrinsics(110.0, 112.0, 39.5, 29.0, 80, 60)


def _frame(seed: int = 0, intrinsics: CameraIntrinsics = K) -> DepthFrame:
    rng = np.random.default_rng(seed)
    depth = rng.uniform(0.4, 2.0, (intrinsics.height, intrinsics.width)).astype(np.float32)
    depth[rng.random(depth.shape) < 0.3] = 0
    colour = rng.integers(0, 256, (*depth.shape, 3), dtype=np.uint8)
    return DepthFrame(depth, intrinsics, colour=colour)


def _parameters(k: CameraIntrinsics) -> list[float]:
    return [k.fx, k.fy, k.cx, k.cy]


@settings(deadline=None, max_examples=40)
@given(
    width=st.integers(48, 120),
    height=st.integers(48, 120),
    fx=st.floats(40, 300),
    fy=st.floats(40, 300),
    cx=st.floats(-20, 140),
    cy=st.floats(-20, 140),
    seed=st.integers(0, 1000),
)
def test_exact_intrinsics_are_recovered(
    width: int, height: int, fx: float, fy: float, cx: float, cy: float, seed: int
) -> None:
    frame = _frame(seed, CameraIntrinsics(fx, fy, cx, cy, width, height))
    back = frame_from_cloud(cloud_from_frame(frame))
    np.testing.assert_array_equal(back.depth, frame.depth)
    np.testing.assert_array_equal(back.colour, frame.colour)
    expected = _parameters(frame.intrinsics)
    np.testing.assert_allclose(_parameters(back.intrinsics), expected, rtol=0, atol=1e-3)


def test_grid_has_pixel_order_and_nan_for_missing() -> None:
    frame = _frame()
    table = cloud_from_frame(frame)
    assert (table.width, table.height) == (80, 60)
    assert table.points.dtype == np.float32
    points = table.points.reshape(60, 80, 3)
    np.testing.assert_array_equal(np.isnan(points).all(axis=-1), ~frame.valid)
    np.testing.assert_allclose(points[frame.valid], frame.points()[frame.valid], atol=1e-6)


def test_stereo_outliers_do_not_change_intrinsics() -> None:
    rng = np.random.default_rng(5)
    points = cloud_from_frame(_frame()).points.reshape(60, 80, 3).astype(np.float64)
    outliers = rng.random((60, 80)) < 0.04
    points[outliers, :2] = rng.normal(scale=30.0, size=(int(outliers.sum()), 2))
    recovered = recover_intrinsics(points)
    np.testing.assert_allclose(_parameters(recovered), _parameters(K), atol=1e-3)


def test_few_readings_suffice() -> None:
    points = cloud_from_frame(_frame()).points.reshape(60, 80, 3).copy()
    keep = np.zeros((60, 80), dtype=bool)
    keep[::20, ::16] = True
    points[~keep] = np.nan
    np.testing.assert_allclose(_parameters(recover_intrinsics(points)), _parameters(K), atol=1e-3)


def test_readings_mostly_in_one_column_suffice() -> None:
    points = cloud_from_frame(DepthFrame(np.full((60, 80), 0.7, np.float32), K)).points
    points = points.reshape(60, 80, 3).copy()
    points[5:, :40] = points[5:, 41:] = np.nan
    np.testing.assert_allclose(_parameters(recover_intrinsics(points)), _parameters(K), atol=1e-3)


def test_millimetre_rounding_is_tolerated() -> None:
    points = cloud_from_frame(_frame()).points.reshape(60, 80, 3).astype(np.float64).round(3)
    np.testing.assert_allclose(_parameters(recover_intrinsics(points)), _parameters(K), atol=0.1)


def test_zero_points_are_missing_readings() -> None:
    table = cloud_from_frame(_frame())
    filled = PointTable(np.nan_to_num(table.points), table.colours, 80, 60)
    np.testing.assert_array_equal(frame_from_cloud(filled).depth, _frame().depth)


def test_known_camera_is_used_unchanged() -> None:
    recovered = frame_from_cloud(cloud_from_frame(_frame()), CameraFile(K))
    assert recovered.intrinsics == K


def test_wrong_camera_is_rejected() -> None:
    wrong = CameraIntrinsics(110.0, 112.0, 36.5, 29.0, 80, 60)
    with pytest.raises(InputError, match=r"points miss their pixels by at least 3 px at fx=110"):
        frame_from_cloud(cloud_from_frame(_frame()), CameraFile(wrong))


@pytest.mark.parametrize("angle", [0.3, 0.8])
def test_cloud_in_world_frame_is_rejected(angle: float) -> None:
    rotated = Rotation.from_rotvec([angle, 0.2, 0.1]).apply(cloud_from_frame(_frame()).points)
    table = PointTable(rotated + np.array([0.3, -0.2, 2.5]), None, 80, 60)
    with pytest.raises(InputError, match=r"not a pinhole image in the camera frame: .*expected"):
        frame_from_cloud(table)


@pytest.mark.parametrize(
    ("signs", "message"),
    [
        ([-1, 1, 1], "x/z does not grow with the column; expected x right, y down, z forward"),
        ([1, -1, 1], "y/z does not grow with the row"),
        ([1, -1, -1], r"\d+ points lie behind the camera \(lowest z -.* m\): expected the optical"),
    ],
)
def test_flipped_axes_are_rejected(signs: list[int], message: str) -> None:
    table = PointTable(cloud_from_frame(_frame()).points * np.array(signs), None, 80, 60)
    with pytest.raises(InputError, match=message):
        frame_from_cloud(table)


def test_single_column_is_rejected() -> None:
    points = cloud_from_frame(_frame()).points.reshape(60, 80, 3).copy()
    points[:, 1:] = np.nan
    with pytest.raises(InputError, match=r"lie in a single column, .*: pass camera intrinsics"):
        recover_intrinsics(points)


def test_cloud_without_readings_is_rejected() -> None:
    table = PointTable(np.full((4, 3), np.nan), None, 2, 2)
    with pytest.raises(InputError, match="no point has a reading"):
        frame_from_cloud(table)


def test_millimetres_are_detected() -> None:
    table = PointTable(cloud_from_frame(_frame()).points * np.float32(1000), None, 80, 60)
    with pytest.raises(InputError, match=r"looks like millimetres .* \(centimetres by 0\.01\)"):
        frame_from_cloud(table)


def test_unorganised_cloud_is_rejected() -> None:
    table = PointTable(np.ones((6, 3)), None, 6, 1)
    with pytest.raises(InputError, match=r"no pixel grid \(6 points, width 6, height 1\).*eyehand"):
        frame_from_cloud(table)


def test_cloud_without_grid_is_projected_in_any_order() -> None:
    frame = _frame()
    table = cloud_from_frame(frame)
    assert table.colours is not None
    read = np.flatnonzero(np.isfinite(table.points[:, 2]))
    order = np.random.default_rng(1).permutation(read)
    back = frame_from_cloud(PointTable(table.points[order], table.colours[order]), CameraFile(K))
    np.testing.assert_array_equal(back.depth, frame.depth)
    assert back.colour is not None
    assert frame.colour is not None
    np.testing.assert_array_equal(back.colour[back.valid], frame.colour[frame.valid])


def test_nearer_of_two_points_on_a_pixel_is_kept() -> None:
    rays = K.rays().reshape(-1, 3)
    points = np.concatenate([rays * 0.9, rays[500:501] * 0.5])
    for order in (slice(None), slice(None, None, -1)):
        depth = frame_from_cloud(PointTable(points[order]), CameraFile(K)).depth.ravel()
        assert depth[500] == np.float32(0.5)
        assert np.count_nonzero(depth == np.float32(0.9)) == depth.size - 1


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"fx": 125.0}, "px from the middles of the camera's pixels"),
        ({"cy": 29.4}, "px from the middles"),
        ({"width": 30}, "of .* points lie in the image of the camera"),
    ],
)
def test_cloud_of_another_camera_is_rejected(change: dict[str, float], message: str) -> None:
    points = cloud_from_frame(_frame()).points
    with pytest.raises(InputError, match=message):
        frame_from_cloud(PointTable(points), CameraFile(dataclasses.replace(K, **change)))


def test_thinned_cloud_is_rejected() -> None:
    points = cloud_from_frame(_frame()).points
    kept = np.random.default_rng(0).random(len(points)) < 0.7
    with pytest.raises(InputError, match=r"neighbour on 4\d % .* before it was thinned"):
        frame_from_cloud(PointTable(points[kept]), CameraFile(K))


def test_points_behind_the_camera_are_rejected_without_a_grid() -> None:
    points = -cloud_from_frame(_frame()).points
    with pytest.raises(InputError, match=r"0 of .* points lie in the image .* z forward"):
        frame_from_cloud(PointTable(points), CameraFile(K))


def test_grid_of_wrong_size_is_rejected() -> None:
    table = PointTable(np.ones((6, 3)), None, 2, 2)
    with pytest.raises(InputError, match="declares 2x2 px but holds 6 points, expected 4"):
        frame_from_cloud(table)


def test_extreme_coordinates_raise() -> None:
    points = np.zeros((2, 2, 3))
    points[..., 2] = 1e-300
    points[0, 1] = [1e300, 1e300, 1e-300]
    with pytest.raises(InputError):
        recover_intrinsics(points)
