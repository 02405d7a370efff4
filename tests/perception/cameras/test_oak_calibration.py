"""Tests of intrinsics from calibration files at several image sizes."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import pytest

from eyehand.errors import InputError
from eyehand.perception.cameras import intrinsics_from_calibration
from eyehand.perception.cameras.depthai_import import load_depthai

if TYPE_CHECKING:
    from pathlib import Path

K = [[1201.5, 0.0, 638.25], [0.0, 1200.5, 402.75], [0.0, 0.0, 1.0]]


@pytest.fixture
def calibration(tmp_path: Path) -> Path:
    """Return a calibration file of one colour camera at 1280x800 px, written by depthai."""
    load_depthai()
    import depthai as dai

    handler = dai.CalibrationHandler()
    handler.setCameraIntrinsics(dai.CameraBoardSocket.CAM_A, K, dai.Size2f(1280, 800))
    handler.setDistortionCoefficients(dai.CameraBoardSocket.CAM_A, [0.05] * 14)
    path = tmp_path / "calibration.json"
    assert handler.eepromToJsonFile(path)
    return path


def test_calibrated_size_gives_calibrated_intrinsics(calibration: Path) -> None:
    k = intrinsics_from_calibration(calibration, "CAM_A", 1280, 800)

    assert (k.fx, k.fy, k.cx, k.cy) == (1201.5, 1200.5, 638.25, 402.75)
    assert (k.width, k.height) == (1280, 800)


def test_half_size_halves_focal_length(calibration: Path) -> None:
    k = intrinsics_from_calibration(calibration, "CAM_A", 640, 400)

    np.testing.assert_allclose((k.fx, k.fy), (600.75, 600.25), rtol=1e-6)
    # With pixel centres at integers cx is 318.875. The docstring states this 0.25 px difference.
    np.testing.assert_allclose((k.cx, k.cy), (319.125, 201.375), rtol=1e-6)


def test_wider_aspect_ratio_crops_centre(calibration: Path) -> None:
    k = intrinsics_from_calibration(calibration, "CAM_A", 1280, 720)

    np.testing.assert_allclose((k.fx, k.fy), (1201.5, 1200.5), rtol=1e-6)
    np.testing.assert_allclose((k.cx, k.cy), (638.25, 402.75 - 40), rtol=1e-6)


def test_uncalibrated_camera_is_reported(calibration: Path) -> None:
    with pytest.raises(InputError, match="holds no calibration of the camera at CAM_B"):
        intrinsics_from_calibration(calibration, "CAM_B", 640, 400)


@pytest.mark.parametrize("socket", ["CAM_Z", "AUTO", "left", ""])
def test_unknown_socket_lists_valid_names(calibration: Path, socket: str) -> None:
    with pytest.raises(InputError, match=f"no camera socket '{socket}': must be one of CAM_A, CAM"):
        intrinsics_from_calibration(calibration, socket, 640, 400)


@pytest.mark.parametrize(("width", "height"), [(0, 400), (640, -1)])
def test_invalid_size_is_rejected(calibration: Path, width: int, height: int) -> None:
    with pytest.raises(InputError, match="image size must be >= 1 px"):
        intrinsics_from_calibration(calibration, "CAM_A", width, height)


def test_missing_file_is_reported(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"nothing\.json: no such file"):
        intrinsics_from_calibration(tmp_path / "nothing.json")


@pytest.mark.parametrize("content", ["", "{", "[1, 2]", "{}", "null", '{"cameraData": 3}', "\x00"])
def test_invalid_file_is_rejected_in_one_line(
    tmp_path: Path, content: str, capfd: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "calibration.json"
    path.write_text(content)

    with pytest.raises(InputError, match=r"calibration\.json: ") as caught:
        intrinsics_from_calibration(path)
    assert "\n" not in str(caught.value)
    assert capfd.readouterr() == ("", "")
