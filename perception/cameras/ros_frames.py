"""Write depth frames as ROS 2 messages: images, camera, colour and pose."""

from __future__ import annotations

import time
from collections.abc import Generator, Iterable
from contextlib import closing
from pathlib import Path

import numpy as np

from eyehand.errors import InputError

from ..frame import DepthFrame
from .ros_messages import RosWriter, load_ros, ros_header, ros_transform, ros_writer

SUFFIX = ".mcap"
"""Suffix of recordings."""
TOPIC, TF, TF_STATIC = "/camera/depth", "/tf", "/tf_static"
"""Topics of the depth images, and of a pose of the camera that changes, or does not."""
WORLD, CAMERA = "world", "camera"
"""Names of the coordinate frames."""


def write_ros_frames(
    path: Path, frames: Iterable[DepthFrame], *, topic: str = TOPIC, fps: float = 10.0
) -> None:
    """Write a recording of depth frames, see `write_ros_frame`.

    Raises
    ------
    InputError
        If the extra `ros` is not installed, or the file cannot be written.
    """
    with ros_writer(path) as writer:
        for number, frame in enumerate(frames):
            write_ros_frame(writer, frame, number / fps, topic)


def write_ros_frame(
    writer: RosWriter, frame: DepthFrame, seconds: float, topic: str = TOPIC
) -> None:
    """Write the depth of a frame as 32FC1 in m with CameraInfo, and colour and pose if known.

    Parameters
    ----------
    writer
        The recording.
    frame
        The frame.
    seconds
        Its time, s.
    topic
        Topic of the depth images. CameraInfo and colour are beside it.
    """
    k = frame.intrinsics
    head = {"header": ros_header(seconds, CAMERA), "height": k.height, "width": k.width}
    image = {"encoding": "32FC1", "is_bigendian": 0, "step": 4 * k.width}
    matrix = k.matrix
    projection = np.hstack([matrix, np.zeros((3, 1))])
    info = {
        "distortion_model": "plumb_bob",
        "d": [0.0] * 5,
        "k": matrix.ravel().tolist(),
        "r": np.eye(3).ravel().tolist(),
        "p": projection.ravel().tolist(),
        "binning_x": 0,
        "binning_y": 0,
        "roi": {"x_offset": 0, "y_offset": 0, "height": 0, "width": 0, "do_rectify": False},
    }
    if frame.T_world_camera is not None:
        pose = ros_transform(seconds, WORLD, CAMERA, frame.T_world_camera)
        writer.write(TF, "tf2_msgs/TFMessage", {"transforms": [pose]}, seconds)
    if frame.colour is not None:
        colour = {"encoding": "rgb8", "step": 3 * k.width, "data": frame.colour.tobytes()}
        writer.write(colour_topic(topic), "sensor_msgs/Image", head | image | colour, seconds)
    depth = {"data": np.ascontiguousarray(frame.depth, "<f4").tobytes()}
    writer.write(topic, "sensor_msgs/Image", head | image | depth, seconds)
    beside = f"{topic.rpartition('/')[0]}/camera_info"
    writer.write(beside, "sensor_msgs/CameraInfo", head | info, seconds)


def colour_topic(topic: str) -> str:
    """Return the topic of the colour of the depth images of a topic."""
    return f"{topic.rpartition('/')[0]}/colour"


def check_recording(path: Path | str) -> Path:
    """Check that a recording can be written to a path, and return it.

    Raises
    ------
    InputError
        If the name does not end in .mcap, the folder is missing, or the extra `ros` is not
        installed.
    """
    path = Path(path)
    if path.suffix.lower() != SUFFIX:
        raise InputError(f"cannot record to {path}: the name must end in {SUFFIX}")
    if not path.parent.is_dir():
        raise InputError(f"cannot record to {path}: there is no folder {path.parent}")
    load_ros("mcap_ros2.writer")
    return path


def recorded(
    frames: Generator[DepthFrame, None, None], path: Path
) -> Generator[DepthFrame, None, None]:
    """Yield frames, and write them to a recording that appears when the stream ends.

    It is complete however the stream ends: also if the reader stops early, the user presses Ctrl-C
    or the camera is lost. Without frames there is no recording. The stream of frames is closed.

    Raises
    ------
    InputError, DeviceError
        If the file cannot be written; all errors of the stream.
    """
    ending: BaseException | None = None
    with closing(frames):
        frame = next(frames, None)
        if frame is None:
            return
        with ros_writer(path) as writer:
            while frame is not None:
                write_ros_frame(writer, frame, time.time())
                try:
                    yield frame
                    frame = next(frames, None)
                except BaseException as error:
                    # It is raised again when the recording is complete.
                    ending, frame = error, None
    if ending is not None:
        raise ending
