"""A live Luxonis OAK camera with stereo depth aligned to colour."""

from __future__ import annotations

import time
from dataclasses import dataclass
from typing import TYPE_CHECKING

from eyehand.errors import DeviceError, InputError

from .depthai_import import load_depthai
from .oak_message import depth_frame, images, next_pair, paired
from .ros_frames import check_recording, recorded

if TYPE_CHECKING:
    from collections.abc import Generator
    from pathlib import Path

    import depthai as dai
    from scipy.spatial.transform import RigidTransform

    from ..frame import DepthFrame

PRESETS = (
    "default",
    "accuracy",
    "density",
    "face",
    "fast_accuracy",
    "fast_density",
    "high_detail",
    "robotics",
)
"""depthai's stereo presets, in lower case."""


@dataclass(frozen=True)
class OakOptions:
    """Image size, rate and stereo settings of an OAK camera.

    Raises
    ------
    InputError
        If a value is out of its range.
    """

    width: int = 640
    """Columns of depth and colour, px. More show smaller objects and lower the frame rate."""
    height: int = 400
    """Rows of depth and colour, px."""
    fps: float = 15.0
    """Frames per second. A higher rate lowers latency and costs bandwidth and exposure time."""
    preset: str = "default"
    """Stereo preset, one of `PRESETS`. Presets trade complete depth against exact edges."""
    colour: bool = True
    """Whether frames include the colour image. Depth is always aligned to the colour camera."""
    device: str | None = None
    """Device id, IP address or USB path of the camera. None selects the first one found."""
    timeout_s: float = 5.0
    """Maximum time without a frame or without any reading before the camera counts as lost, s. The
    sensors need about 1 s to start."""

    def __post_init__(self) -> None:
        if self.width < 1 or self.height < 1:
            raise InputError(f"image size must be >= 1 px, got {self.width}x{self.height}")
        if not (self.fps > 0 and self.timeout_s > 0):
            raise InputError(
                f"fps and time-out must be > 0, got {self.fps} fps and {self.timeout_s} s"
            )
        if self.preset not in PRESETS:
            raise InputError(f"no stereo preset {self.preset!r}: must be one of {PRESETS}")


class OakCamera:
    """A live OAK camera (a `Camera`), with its own calibration.

    Parameters
    ----------
    options : OakOptions
        Image size, rate, stereo preset, which device.
    record : Path or str, optional
        Also write every frame to this recording (`*.mcap`), which `RosRecording` reads. The file
        appears when the stream ends. It needs the extra `ros`.
    T_world_camera : RigidTransform, optional
        Pose of the colour camera's optical frame, copied into every frame.
    """

    def __init__(
        self,
        options: OakOptions | None = None,
        *,
        record: Path | str | None = None,
        T_world_camera: RigidTransform | None = None,
    ) -> None:
        self.options = options or OakOptions()
        """Settings of the camera."""
        self.record = record
        """Recording to write, or None."""
        self.T_world_camera = T_world_camera
        """Pose of the camera, or None."""

    def frames(self) -> Generator[DepthFrame, None, None]:
        """Yield the newest frame each time. A slow reader skips frames and does not fall behind.

        Frames without any reading (a covered lens) are skipped. The device stays open until the
        iterator ends, is closed or is deleted.

        Raises
        ------
        DeviceError
            At once if no camera is connected; later if it cannot be opened, has no colour camera
            or stereo pair, or falls silent.
        InputError
            If the recording cannot be written where it was asked for.
        """
        if self.record is None:
            return self._stream(find_device(self.options.device))
        path = check_recording(self.record)
        return recorded(self._stream(find_device(self.options.device)), path)

    def _stream(self, info: dai.DeviceInfo) -> Generator[DepthFrame, None, None]:
        import depthai as dai

        try:
            device = dai.Device(info)
        except RuntimeError as error:
            raise _device_error(f"cannot open the OAK camera {info.name}", error) from error
        try:
            pipeline = dai.Pipeline(device)
            try:
                queue = aligned_stereo(pipeline, device, self.options)
                pipeline.start()
            except RuntimeError as error:
                raise _device_error("the OAK camera refuses the pipeline", error) from error
            try:
                yield from live_frames(queue, self.options.timeout_s, self.T_world_camera)
            finally:
                pipeline.stop()
                pipeline.wait()
        finally:
            device.close()


def find_device(wanted: str | None = None) -> dai.DeviceInfo:
    """Find a connected OAK camera, in about half a second.

    Parameters
    ----------
    wanted : str, optional
        Device id, IP address or USB path; None takes the first one found.

    Raises
    ------
    DeviceError
        If there is none, or none of that name.
    """
    load_depthai()
    import depthai as dai

    # For an absent device depthai fails only after more than eleven seconds.
    devices = dai.Device.getAllAvailableDevices()
    if not devices:
        raise DeviceError(
            "no OAK camera found: connect one by USB or network (in a container, pass in "
            "/dev/bus/usb)"
        )
    for info in devices:
        if wanted is None or wanted in (info.deviceId, info.name):
            return info
    names = ", ".join(f"{info.deviceId} at {info.name}" for info in devices)
    raise DeviceError(f"no OAK camera {wanted!r} found, only {names}")


def aligned_stereo(
    pipeline: dai.Pipeline, device: dai.Device, options: OakOptions
) -> dai.MessageQueue:
    """Set up undistorted colour and stereo depth seen from the colour camera, in mm, paired.

    Raises
    ------
    DeviceError
        If the device has no colour camera.
    RuntimeError
        By depthai, if the device has no stereo pair or cannot deliver the size or rate.
    """
    import depthai as dai

    sockets = device.getConnectedCameras(dai.CameraSensorType.COLOR)
    if not sockets:
        raise DeviceError(
            f"the OAK camera {device.getDeviceName()} has no colour camera to align depth to"
        )
    size = (options.width, options.height)
    colour = (
        pipeline.create(dai.node.Camera)
        .build(sockets[0])
        .requestOutput(
            size,
            type=dai.ImgFrame.Type.RGB888i,
            resizeMode=dai.ImgResizeMode.CROP,
            fps=options.fps,
            enableUndistortion=True,
        )
    )
    preset = dai.node.StereoDepth.PresetMode.__members__[options.preset.upper()]
    stereo = pipeline.create(dai.node.StereoDepth).build(
        True, presetMode=preset, size=size, fps=options.fps
    )
    stereo.initialConfig.setDepthUnit(dai.LengthUnit.MILLIMETER)
    if device.getPlatform() == dai.Platform.RVC4:
        # The stereo unit of this device generation cannot align depth to another camera.
        align = pipeline.create(dai.node.ImageAlign)
        stereo.depth.link(align.input)
        colour.link(align.inputAlignTo)
        depth = align.outputAligned
    else:
        colour.link(stereo.inputAlignTo)
        depth = stereo.depth
    half_a_frame = 0.5 / options.fps
    with_colour = colour if options.colour else None
    return paired(pipeline, depth, with_colour, half_a_frame)


def live_frames(
    queue: dai.MessageQueue, timeout_s: float, T_world_camera: RigidTransform | None = None
) -> Generator[DepthFrame, None, None]:
    """Yield frames from a queue of message pairs until the stream ends.

    Parameters
    ----------
    queue : depthai.MessageQueue
        Pairs as `paired` makes them.
    timeout_s : float
        Maximum waiting time for the next frame, s.
    T_world_camera : RigidTransform, optional
        Put into every frame.

    Raises
    ------
    DeviceError
        If no pair comes in time, or none with a depth reading.
    """
    while True:
        yield _next_frame(queue, timeout_s, T_world_camera)


def _next_frame(
    queue: dai.MessageQueue, timeout_s: float, T_world_camera: RigidTransform | None
) -> DepthFrame:
    deadline = time.monotonic() + timeout_s
    dark = 0
    while (pair := next_pair(queue, deadline - time.monotonic())) is not None:
        frame = depth_frame(*images(pair), T_world_camera)
        if frame is not None:
            return frame
        dark += 1
    if dark:
        raise DeviceError(
            f"the OAK camera measured no depth anywhere in {dark} images ({timeout_s:g} s): is a "
            "lens covered, or everything closer than it can see?"
        )
    raise DeviceError(f"the OAK camera sent nothing for {timeout_s:g} s: is it still connected?")


def _device_error(what: str, error: Exception) -> DeviceError:
    return DeviceError(f"{what}: {' '.join(str(error).split())}")
