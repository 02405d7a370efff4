"""Camera intrinsics from the calibration file of an OAK camera."""

from __future__ import annotations

from pathlib import Path

from eyehand.errors import InputError

from ..frame import CameraIntrinsics
from .depthai_import import load_depthai

SOCKET_PREFIX = "CAM_"
"""Prefix of the names of camera sockets, on the board and in depthai."""


def intrinsics_from_calibration(
    path: Path | str, socket: str = "CAM_A", width: int = 1280, height: int = 800
) -> CameraIntrinsics:
    """Read the pinhole camera of one sensor, scaled and centre-cropped to an image size.

    depthai scales the principal point with the image (half the size, half the value). This assumes
    that pixel centres lie at half-integers. For a camera that was calibrated at twice the size, the
    error is 0.25 px. Lens distortion is ignored: the result is valid for undistorted images.

    Parameters
    ----------
    path : Path or str
        Calibration JSON as `CalibrationHandler.eepromToJsonFile` writes it.
    socket : str
        Camera socket, "CAM_A" (colour on most models), "CAM_B" (left), "CAM_C" (right), ...
    width, height : int
        Size of the images, px.

    Raises
    ------
    InputError
        If the file is missing or not a calibration, has no such camera, or a size is not positive.
    """
    path = Path(path)
    if width < 1 or height < 1:
        raise InputError(f"image size must be >= 1 px, got {width}x{height}")
    if not path.is_file():
        raise InputError(f"{path}: no such file")
    load_depthai()
    import depthai as dai

    board_socket = dai.CameraBoardSocket.__members__.get(socket)
    if board_socket is None or not socket.startswith(SOCKET_PREFIX):
        known = sorted(n for n in dai.CameraBoardSocket.__members__ if n.startswith(SOCKET_PREFIX))
        raise InputError(f"there is no camera socket {socket!r}: must be one of {', '.join(known)}")
    try:
        # Skip the check of the extrinsics in depthai: only the intrinsics are needed.
        calibration = dai.CalibrationHandler(path.absolute(), validateExtrinsics=False)
        known_camera = calibration.hasCameraCalibration(board_socket)
        K = calibration.getCameraIntrinsics(board_socket, width, height) if known_camera else None
    except (RuntimeError, ValueError) as error:
        fault = " ".join(str(error).split())
        raise InputError(f"{path}: not an OAK calibration file ({fault})") from error
    if K is None:
        raise InputError(f"{path}: holds no calibration of the camera at {socket}")
    return CameraIntrinsics(K[0][0], K[1][1], K[0][2], K[1][2], width, height)
