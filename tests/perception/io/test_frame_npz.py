"""Tests of depth frames in NPZ archives: units, cameras and precedence."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import RigidTransform, Rotation

from eyehand.errors import InputError
from eyehand.perception import CameraIntrinsics, DepthFrame
from eyehand.perception.io.frame_npz import read_npz_frame, write_npz_frame
from eyehand.perception.io.intrinsics import write_intrinsics

K = CameraIntrinsics(5.0, 6.0, 1.5, 1.0, 4, 3)
DEPTH = np.linspace(0.5, 1.2, 12, dtype=np.float32).reshape(3, 4)
PINHOLE = np.array([5.0, 6.0, 1.5, 1.0])
"""fx, fy, cx, cy of K, px."""
POSE = RigidTransform.from_components([0.1, 0.2, 0.9], Rotation.from_rotvec([2.5, 0.1, 0.2]))


def _find_no_camera(path: Path) -> Path:
    raise InputError(f"{path}: no camera intrinsics")


def _read(tmp_path: Path, camera: Path | None = None, **arrays: Any) -> DepthFrame:
    np.savez(tmp_path / "a.npz", **arrays)
    return read_npz_frame(tmp_path / "a.npz", camera, _find_no_camera)


def test_written_frame_is_read_back_exactly(tmp_path: Path) -> None:
    colour = np.arange(36, dtype=np.uint8).reshape(3, 4, 3)
    frame = DepthFrame(DEPTH, K, POSE, colour)
    write_npz_frame(tmp_path / "a.npz", frame)
    back = read_npz_frame(tmp_path / "a.npz", None, _find_no_camera)
    np.testing.assert_array_equal(back.depth, DEPTH)
    np.testing.assert_array_equal(back.colour, colour)
    assert back.intrinsics == K
    assert back.T_world_camera is not None
    np.testing.assert_allclose(back.T_world_camera.as_matrix(), POSE.as_matrix(), atol=1e-14)


def test_camera_matrix_sets_intrinsics(tmp_path: Path) -> None:
    assert _read(tmp_path, depth=DEPTH, K=K.matrix).intrinsics == K
    assert _read(tmp_path, depth=DEPTH, intrinsics=K.matrix).intrinsics == K


@pytest.mark.parametrize("dtype", [np.uint16, np.int32, np.uint64])
def test_integer_depth_uses_scale_of_archive(tmp_path: Path, dtype: type) -> None:
    raw = np.full((3, 4), 7820, dtype=dtype)
    frame = _read(tmp_path, depth=raw, depth_scale_m=1e-4, intrinsics=PINHOLE)
    np.testing.assert_array_equal(frame.depth, np.full((3, 4), 0.782, dtype=np.float32))


def test_integer_depth_uses_scale_of_camera_file(tmp_path: Path) -> None:
    camera = write_intrinsics(tmp_path / "k.json", K, depth_scale_mm=0.1)
    frame = _read(tmp_path, camera, depth=np.full((3, 4), 7820, dtype=np.uint16))
    np.testing.assert_array_equal(frame.depth, np.full((3, 4), 0.782, dtype=np.float32))
    assert frame.intrinsics == K


def test_camera_file_overrides_archive(tmp_path: Path) -> None:
    camera = write_intrinsics(tmp_path / "k.json", K, T_world_camera=POSE)
    frame = _read(tmp_path, camera, depth=DEPTH, intrinsics=PINHOLE + 1, T_world_camera=np.eye(4))
    assert frame.intrinsics == K
    assert frame.T_world_camera is not None
    np.testing.assert_allclose(frame.T_world_camera.as_matrix(), POSE.as_matrix(), atol=1e-12)


def test_archive_pose_is_kept_without_pose_in_camera_file(tmp_path: Path) -> None:
    camera = write_intrinsics(tmp_path / "k.json", K)
    frame = _read(tmp_path, camera, depth=DEPTH, T_world_camera=POSE.as_matrix())
    assert frame.T_world_camera is not None
    np.testing.assert_allclose(frame.T_world_camera.as_matrix(), POSE.as_matrix(), atol=1e-12)


RAW = np.full((3, 4), 700, dtype=np.uint16)
SKEWED = K.matrix + np.array([[0, 0.5, 0], [0, 0, 0], [0, 0, 0]])


@pytest.mark.parametrize(
    ("arrays", "message"),
    [
        ({"rgb": RAW}, r"a\.npz: holds rgb, expected an array `depth`"),
        ({"other": RAW}, r"a\.npz: holds \['other'\], expected one of \['depth'"),
        ({"depth": RAW, "intrinsics": PINHOLE}, "depth is uint16 and its unit is not given"),
        ({"depth": DEPTH}, "no camera intrinsics"),
        ({"depth": DEPTH.ravel(), "intrinsics": PINHOLE}, r"depth is \(12,\) float32, expected"),
        ({"depth": DEPTH > 0, "intrinsics": PINHOLE}, r"depth is \(3, 4\) bool, expected"),
        ({"depth": DEPTH[:0], "intrinsics": PINHOLE}, r"depth is \(0, 4\) float32, expected"),
        ({"depth": DEPTH * np.nan, "intrinsics": PINHOLE}, "depth is 0 everywhere"),
        ({"depth": -DEPTH, "intrinsics": PINHOLE}, r"negative values \(lowest -1\.2 m\)"),
        ({"depth": DEPTH * 0, "intrinsics": PINHOLE}, "depth is 0 everywhere"),
        ({"depth": DEPTH * 1000, "intrinsics": PINHOLE}, "millimetres given as metres"),
        ({"depth": DEPTH.astype(float) * 1e300, "intrinsics": PINHOLE}, "infinite"),
        ({"depth": RAW, "depth_scale_m": 1.0, "intrinsics": PINHOLE}, "millimetres given as met"),
        ({"depth": RAW, "depth_scale_m": 1e-6, "intrinsics": PINHOLE}, r"median depth is 0\.7 mm"),
        ({"depth": RAW, "depth_scale_m": -1.0, "intrinsics": PINHOLE}, "depth_scale_m is -1, exp"),
        ({"depth": RAW, "depth_scale_m": "mm", "intrinsics": PINHOLE}, "depth_scale_m is .*one nu"),
        ({"depth": RAW, "depth_scale_m": [1, 2], "intrinsics": PINHOLE}, r"is \(2,\) int64"),
        ({"depth": DEPTH, "depth_scale_m": 1e-3, "intrinsics": PINHOLE}, "float32 and so in metr"),
        ({"depth": DEPTH, "intrinsics": K.matrix[:2]}, r"intrinsics is \(2, 3\) .*fx, fy, cx, cy"),
        ({"depth": DEPTH, "intrinsics": PINHOLE * np.nan}, "intrinsics must be finite"),
        ({"depth": DEPTH, "K": K.matrix.T}, r"K \(row-major\): the matrix has last row \[1\.5"),
        ({"depth": DEPTH, "K": PINHOLE}, r"K \(row-major\) must be a \(3, 3\)"),
        ({"depth": DEPTH, "K": SKEWED}, "skew 0.5"),
        ({"depth": DEPTH, "intrinsics": PINHOLE, "T_world_camera": np.eye(3)}, r"a \(4, 4\)"),
        ({"depth": DEPTH, "intrinsics": PINHOLE, "rgb": RAW}, r"colour must be \(3, 4, 3\) uint8"),
    ],
)
def test_invalid_archives_are_rejected(
    tmp_path: Path, arrays: dict[str, Any], message: str
) -> None:
    with pytest.raises(InputError, match=message) as caught:
        _read(tmp_path, **arrays)
    assert "a.npz" in str(caught.value)
    assert "\n" not in str(caught.value)


def test_conflicting_scales_are_rejected(tmp_path: Path) -> None:
    camera = write_intrinsics(tmp_path / "k.json", K, depth_scale_mm=0.1)
    with pytest.raises(InputError, match=r"says 1 mm per unit .* camera file says 0\.1"):
        _read(tmp_path, camera, depth=RAW, depth_scale_m=0.001)
    agreeing = write_intrinsics(tmp_path / "l.json", K, depth_scale_mm=1.0)
    assert _read(tmp_path, agreeing, depth=RAW, depth_scale_m=0.001).depth[0, 0] == np.float32(0.7)


def test_misspelt_pose_is_rejected_and_other_arrays_are_ignored(tmp_path: Path) -> None:
    matrix = POSE.as_matrix()
    with pytest.raises(InputError, match="T_world_cam: did you mean T_world_camera"):
        _read(tmp_path, depth=DEPTH, intrinsics=PINHOLE, T_world_cam=matrix)
    with pytest.raises(InputError, match="extrinsics must be named T_world_camera"):
        _read(tmp_path, depth=DEPTH, intrinsics=PINHOLE, extrinsics=matrix)
    _read(tmp_path, depth=DEPTH, intrinsics=PINHOLE, pose=matrix, T_world_camera=matrix)


def test_lens_that_distorts_is_rejected(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"dist must be zero, got .*: undistort the images"):
        _read(tmp_path, depth=DEPTH, intrinsics=PINHOLE, dist=np.array([0.1, -0.2, 0, 0, 0]))
    assert _read(tmp_path, depth=DEPTH, intrinsics=PINHOLE, dist=np.zeros(5), D=DEPTH + 1)


def test_nan_is_no_reading_and_color_is_read(tmp_path: Path) -> None:
    colour = np.full((3, 4, 3), 7, dtype=np.uint8)
    holed = np.where(DEPTH > 0.6, DEPTH, np.nan)
    frame = _read(tmp_path, depth=holed, intrinsics=PINHOLE, color=colour)
    np.testing.assert_array_equal(frame.depth, np.where(DEPTH > 0.6, DEPTH, 0))
    np.testing.assert_array_equal(frame.colour, colour)
