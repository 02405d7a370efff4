"""Tests of camera files in four formats, valid and invalid."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import RigidTransform, Rotation

from eyehand.apps.open3d_import import import_open3d
from eyehand.errors import InputError
from eyehand.perception import CameraIntrinsics
from eyehand.perception.io.intrinsics import (
    CAMERA_NAMES,
    find_camera_file,
    read_camera_file,
    read_intrinsics,
    write_intrinsics,
)

K = CameraIntrinsics(600.0, 610.0, 319.5, 241.25, 640, 480)
FLAT = {"fx": 600, "fy": 610.0, "cx": 319.5, "cy": 241.25, "width": 640, "height": 480}
ROW_MAJOR = [600.0, 0.0, 319.5, 0.0, 610.0, 241.25, 0.0, 0.0, 1.0]
COLUMN_MAJOR = [600.0, 0.0, 0.0, 0.0, 610.0, 0.0, 319.5, 241.25, 1.0]
OPEN3D = {"width": 640, "height": 480, "intrinsic_matrix": COLUMN_MAJOR}
BOP = {"cam_K": ROW_MAJOR, "depth_scale": 0.1}


def _write(tmp_path: Path, content: Any) -> Path:
    path = tmp_path / "camera.json"
    path.write_text(content if isinstance(content, str) else json.dumps(content))
    return path


@pytest.mark.parametrize(
    ("content", "scale"),
    [
        (FLAT, None),
        (FLAT | {"depth_scale_mm": 0.25}, 0.25),
        (FLAT | {"depth_scale": 0.5}, 0.5),
        (OPEN3D, None),
        (BOP, 0.1),
        ({"K": ROW_MAJOR, "width": 640, "height": 480}, None),
        ({"k": [ROW_MAJOR[:3], ROW_MAJOR[3:6], ROW_MAJOR[6:]], "width": 640, "height": 480}, None),
        ({"7": BOP}, 0.1),
    ],
)
def test_all_formats_give_same_camera(tmp_path: Path, content: Any, scale: float | None) -> None:
    path = _write(tmp_path, content)
    assert read_intrinsics(path, 640, 480) == K
    assert read_camera_file(path, 640, 480).depth_scale_mm == scale


def test_open3d_file_is_read(tmp_path: Path) -> None:
    open3d = import_open3d()
    path = tmp_path / "k.json"
    camera = open3d.camera.PinholeCameraIntrinsic(640, 480, 600.0, 610.0, 319.5, 241.25)
    assert open3d.io.write_pinhole_camera_intrinsic(str(path), camera)
    assert read_intrinsics(path, 640, 480) == K


finite = st.floats(-1e4, 1e4)
positive = st.floats(1.0, 1e5)


@settings(deadline=None)
@given(positive, positive, finite, finite, st.integers(1, 2896), st.integers(1, 2896))
def test_written_intrinsics_are_read_back_exactly(
    tmp_path_factory: pytest.TempPathFactory,
    fx: float,
    fy: float,
    cx: float,
    cy: float,
    width: int,
    height: int,
) -> None:
    intrinsics = CameraIntrinsics(fx, fy, cx, cy, width, height)
    path = tmp_path_factory.mktemp("k") / "a.json"
    assert write_intrinsics(path, intrinsics) == path
    assert read_intrinsics(path, width, height) == intrinsics


def test_scale_and_pose_round_trip(tmp_path: Path) -> None:
    pose = RigidTransform.from_components([0.1, -0.2, 0.7], Rotation.from_rotvec([2.0, 1.0, 0.1]))
    path = write_intrinsics(tmp_path / "a.json", K, depth_scale_mm=0.1, T_world_camera=pose)
    camera = read_camera_file(path, 640, 480)
    assert camera.depth_scale_mm == 0.1
    assert camera.T_world_camera is not None
    np.testing.assert_allclose(camera.T_world_camera.as_matrix(), pose.as_matrix(), atol=1e-12)
    assert set(json.loads(path.read_text())["T_world_camera"]) == {"quat_wxyz", "translation_m"}


def test_numpy_numbers_are_written(tmp_path: Path) -> None:
    k = CameraIntrinsics(np.float32(600), np.float64(610), 319.5, 241.25, np.int64(640), 480)  # pyright: ignore[reportArgumentType] - what callers pass at run time
    assert read_intrinsics(write_intrinsics(tmp_path / "a.json", k), 640, 480) == K


@pytest.mark.parametrize(
    ("content", "message"),
    [
        ("{fx: 1}", r"camera\.json: not JSON .*expected \{fx, fy, cx, cy"),
        ("\x00\x01", "not JSON"),
        ("[" * 100_000, "not JSON"),
        ("[1, 2]", "holds a JSON list, expected"),
        ({}, "has no keys, expected"),
        ({"K": ROW_MAJOR}, "lacks width, height, expected .*open3d.*column-major.*BOP.*row-major"),
        ({"fx": 600, "cx": 3}, "lacks width, height, expected"),
        ({**FLAT, "fx": "600"}, "fx must be a number, got '600'"),
        ({**FLAT, "fx": True}, "fx must be a number, got True"),
        (json.dumps(FLAT).replace("600", "NaN"), "fx must be a finite number, got nan"),
        ({**FLAT, "fx": 10**400}, "fx must be"),
        ({**FLAT, "fy": 0}, r"focal lengths must be 0.01 to 1e\+06 px, got fy=0"),
        ({k: v for k, v in FLAT.items() if k != "cy"}, "lacks cy, expected"),
        ({**FLAT, "width": 1280}, "the camera is 1280x480 px but the image is 640x480 px"),
        ({**OPEN3D, "height": 481}, "the camera is 640x481 px but the image is 640x480 px"),
        ({**BOP, "width": 64, "height": 48}, "the camera is 64x48 px but"),
        ({**FLAT, "depth_scale_mm": 0}, "depth_scale_mm must be > 0 mm per unit, got 0"),
        ({**FLAT, "depth_scale_mm": "mm"}, "depth_scale_mm must be a number, got 'mm'"),
        ({**FLAT, "T_world_camera": [1]}, "T_world_camera must be .*quat_wxyz"),
        ({**FLAT, "colour": "../a.png"}, "colour must be a file name in the same folder"),
        ({**OPEN3D, "intrinsic_matrix": ROW_MAJOR[:8]}, "list of 9 finite numbers"),
        ({"cam_K": [[600, 0, 319], [0, 610, 240]]}, "cam_K must be a list of 9 finite"),
    ],
)
def test_invalid_files_are_rejected(tmp_path: Path, content: Any, message: str) -> None:
    with pytest.raises(InputError, match=message) as caught:
        read_intrinsics(_write(tmp_path, content), 640, 480)
    assert "\n" not in str(caught.value)


def test_row_major_matrix_in_open3d_format_is_rejected(tmp_path: Path) -> None:
    path = _write(tmp_path, {**OPEN3D, "intrinsic_matrix": ROW_MAJOR})
    message = (
        r"camera\.json: intrinsic_matrix \(column-major\): the matrix has last row "
        r"\[319\.5, 241\.25, 1\.0\], expected \[0, 0, 1\]"
    )
    with pytest.raises(InputError, match=message):
        read_intrinsics(path, 640, 480)


def test_column_major_matrix_in_bop_format_is_rejected(tmp_path: Path) -> None:
    path = _write(tmp_path, {"cam_K": COLUMN_MAJOR})
    with pytest.raises(InputError, match=r"cam_K \(row-major\): the matrix has last row \[319\.5"):
        read_intrinsics(path, 640, 480)


def test_skew_is_rejected(tmp_path: Path) -> None:
    skewed = [600.0, 0.5, *ROW_MAJOR[2:]]
    with pytest.raises(InputError, match=r"skew 0\.5 and 0, expected 0 and 0"):
        read_intrinsics(_write(tmp_path, {"cam_K": skewed}), 640, 480)


def test_file_number_selects_bop_camera(tmp_path: Path) -> None:
    path = _write(tmp_path, {"3": BOP, "12": BOP | {"depth_scale": 1.0}})
    assert read_camera_file(path, 640, 480, "000012").depth_scale_mm == 1.0
    assert read_camera_file(path, 640, 480, "scene2_000003_depth").depth_scale_mm == 0.1


@pytest.mark.parametrize("stem", ["depth", "000004", "3_12"])
def test_ambiguous_image_number_is_rejected(tmp_path: Path, stem: str) -> None:
    path = _write(tmp_path, {"3": BOP, "12": BOP})
    with pytest.raises(InputError, match=r"holds 2 images \(3, 12\) and \d of them fit .*" + stem):
        read_camera_file(path, 640, 480, stem)


def test_camera_file_of_many_images_is_ambiguous(tmp_path: Path) -> None:
    path = _write(tmp_path, {str(i): BOP for i in range(9)})
    with pytest.raises(InputError, match=r"holds 9 images \(0, 1, 2, 3, 4, …\)"):
        read_intrinsics(path, 640, 480)


def test_missing_camera_file_is_reported(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"absent\.json: no such file"):
        read_intrinsics(tmp_path / "absent.json", 640, 480)


def test_camera_file_named_like_image_has_precedence(tmp_path: Path) -> None:
    image = tmp_path / "depth.png"
    assert find_camera_file(image) is None
    for name in (*reversed(CAMERA_NAMES), "depth.json"):
        (tmp_path / name).touch()
        assert find_camera_file(image) == tmp_path / name


@pytest.mark.parametrize(
    ("key", "meant"),
    [
        ("T_world_cam", "T_world_camera"),
        ("depth_scale_m", "depth_scale_mm"),
        ("colours", "colour"),
    ],
)
def test_misspelt_optional_key_is_rejected(tmp_path: Path, key: str, meant: str) -> None:
    for content in (FLAT | {key: 1}, {"7": BOP | {key: 1}}):
        path = _write(tmp_path, content)
        with pytest.raises(InputError, match=rf"camera.json: unknown key {key}: .* {meant}\?"):
            read_camera_file(path, 640, 480)


@pytest.mark.parametrize(
    ("key", "value", "words"),
    [
        ("pose", [0.0], "pose must be named T_world_camera"),
        (
            "dist_coeffs",
            [0.2, 0, 0, 0, 0],
            "dist_coeffs must be zero, got .*: undistort the images",
        ),
        ("dist", [0.1, -0.2, 0, 0], "dist must be zero, got .*: undistort the images"),
        ("coeffs", {"data": [[0, 0.1]]}, "coeffs must be zero"),
        ("distortion", {"k1": 0.1, "p2": 0.0}, "distortion must be zero"),
        ("depth_units", 0.001, "unknown key depth_units: did you mean depth_scale_mm, in mm per"),
        ("depthScale", 0.1, "unknown key depthScale: did you mean depth_scale_mm"),
        ("scale", 1000, "unknown key scale: did you mean depth_scale_mm"),
    ],
)
def test_other_cameras_are_rejected(tmp_path: Path, key: str, value: Any, words: str) -> None:
    with pytest.raises(InputError, match=words):
        read_camera_file(_write(tmp_path, FLAT | {key: value}), 640, 480)


def test_single_coefficients_of_a_lens_are_rejected(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"k1 must be zero, got 0.1"):
        read_camera_file(_write(tmp_path, FLAT | {"k1": 0.1, "k2": 0.0}), 640, 480)


def test_inverse_pose_is_rejected(tmp_path: Path) -> None:
    for key in ("T_camera_world", "T_cam_world"):
        path = _write(tmp_path, FLAT | {key: 1})
        with pytest.raises(InputError, match=f"{key} must be given as its inverse T_world_camera"):
            read_camera_file(path, 640, 480)


def test_other_unknown_keys_are_allowed(tmp_path: Path) -> None:
    added = {
        "T_wrist_camera": 1,
        "distortion": [],
        "distortion_model": 2,
        "dist": 0.8,
        "P2": [700.0, 0, 320, 45, 0, 700, 240, 0, 0, 0, 1, 0],
        "p1": 0.5,
        "cam_R_w2c": ROW_MAJOR,
        "height_m": 0.8,
    }
    assert read_intrinsics(_write(tmp_path, FLAT | added), 640, 480) == K
