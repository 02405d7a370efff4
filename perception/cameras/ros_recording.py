"""Depth frames of MCAP recordings with ROS 2 messages, read without ROS."""

from __future__ import annotations

import struct
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from eyehand.errors import InputError

from ..frame import CameraIntrinsics, DepthFrame, check_image_size
from ..io.depth_units import metres_from_units
from ..io.input_file import naming
from ..io.intrinsics import CameraFile, intrinsics_from_matrix, read_camera_file
from ..io.png import decode_depth
from .mcap_file import check_mcap
from .ros_frames import SUFFIX, TF, TF_STATIC, colour_topic
from .ros_messages import load_ros
from .ros_transforms import TransformTree

IMAGE, COMPRESSED, INFO = (
    f"sensor_msgs/msg/{name}" for name in ("Image", "CompressedImage", "CameraInfo")
)
DTYPES = {"16UC1": "u2", "mono16": "u2", "32FC1": "f4"}
"""Encodings of depth images: whole mm, or m."""
COLOURS = {"rgb8": [0, 1, 2], "bgr8": [2, 1, 0], "rgba8": [0, 1, 2], "bgra8": [2, 1, 0]}
"""Encodings of colour images, with the places of red, green and blue."""
COMPRESSED_HEAD = struct.Struct("<iff")
"""Start of a compressedDepth image: format, and the two parameters of its quantised depth."""
PINHOLE = ("plumb_bob", "rational_polynomial", "")
"""Distortion models that OpenCV corrects, and none."""
RECTIFIED = "image_rect"
"""Part of the name of topics with images that ROS has corrected for the lens."""
MAX_RECORD_BYTES = 1 << 28
"""Maximum size of a record. A chunk of a recorder has some MB."""


class RosRecording:
    """A recording of a depth topic, `sensor_msgs/Image` or compressedDepth, and its CameraInfo.

    Depth is 16UC1 in mm or 32FC1 in m. Lens distortion is corrected by the nearest reading. A topic
    `colour` beside the depth gives the colour of its pixels, as `write_ros_frames` writes it. The
    transforms from `world` to the frame of the depth images give the pose of the camera: the last
    ones before the image in the file, and those of `/tf_static`.

    Parameters
    ----------
    path : Path or str
        MCAP file, or the folder with one that `ros2 bag record -s mcap` writes.
    topic : str
        Topic of the depth images. Empty selects the only one.
    camera : Path, optional
        Camera file with the intrinsics, and the camera's pose if known, instead of CameraInfo.

    Raises
    ------
    InputError
        If the file is missing, truncated or damaged, lacks the topic or its CameraInfo, the folder
        has no or several files, or the extra `ros` is not installed.
    """

    def __init__(
        self, path: Path | str, *, topic: str = "", camera: Path | str | None = None
    ) -> None:
        self.path = _recording_file(Path(path))
        """The recording."""
        check_mcap(self.path)
        topics = self._topics()
        self.topic = self._depth_topic(topics, topic)
        """Topic of the depth images."""
        self._camera = camera
        self._colour = colour_topic(self.topic)
        self._info = "" if camera is not None else self._info_topic(topics)

    def frames(self) -> Iterator[DepthFrame]:
        """Yield the frames in the order in which they were recorded.

        Images without any reading are skipped.

        Raises
        ------
        InputError
            If an image is not usable as depth, comes before its CameraInfo, or is damaged.
        """
        info = None
        if self._info:
            info = next((message for _, message in self._messages([self._info])), None)
        number, colour = -1, None
        frames = TransformTree()
        for _, message in self._messages([TF_STATIC]):
            with self._damage():
                frames.add(message)
        for topic, message in self._messages([self.topic, self._colour, TF]):
            if topic == TF:
                with self._damage():
                    frames.add(message)
                continue
            if topic == self._colour:
                colour = message
                continue
            number += 1
            with naming(f"{self.path}: image {number} of {self.topic}"):
                with self._damage():
                    depth = _depth(message)
                if not depth.any():
                    continue
                height, width = depth.shape
                if info is None:
                    camera = self._camera_file(width, height)
                else:
                    rectified = RECTIFIED in self.topic
                    with self._damage():
                        camera, depth = _undistorted(info, depth, rectified=rectified)
                with self._damage():
                    pixels = None if colour is None else _colour_of(message, colour)
                    pose = camera.T_world_camera
                    if pose is None:
                        pose = frames.world_pose(message.header.frame_id)
                yield DepthFrame(depth, camera.intrinsics, pose, pixels)

    def _camera_file(self, width: int, height: int) -> CameraFile:
        if self._camera is None:
            raise InputError(f"the topic {self._info} holds no message")
        return read_camera_file(self._camera, width, height)

    def _topics(self) -> dict[str, str]:
        """Return the type of every topic."""
        with self.path.open("rb") as file, self._damage():
            summary = _reader(file).get_summary()
            sizes = [chunk.uncompressed_size for chunk in summary.chunk_indexes]
            if max(sizes, default=0) > MAX_RECORD_BYTES:
                raise InputError(
                    f"{self.path}: a chunk has {max(sizes)} bytes unpacked, expected at most "
                    f"{MAX_RECORD_BYTES}"
                )
            return {
                channel.topic: summary.schemas[channel.schema_id].name
                for channel in summary.channels.values()
                if channel.schema_id in summary.schemas
            }

    def _depth_topic(self, topics: dict[str, str], topic: str) -> str:
        images = [name for name, kind in topics.items() if kind in (IMAGE, COMPRESSED)]
        if topic:
            below = [name for name in images if name.startswith(f"{topic.rstrip('/')}/")]
            if topic not in images and len(below) == 1:
                return below[0]
            if topic not in images:
                kind = topics.get(topic)
                fault = f"holds {kind}" if kind else "is not in the recording"
                raise InputError(
                    f"{self.path}: topic {topic} {fault}; topics of images: {_listed(images)}"
                )
            return topic
        if not images:
            raise InputError(f"{self.path}: holds no topic of images, expected one with depth")
        depth = [name for name in images if "depth" in name.lower()]
        if len(depth) != 1:
            raise InputError(
                f"{self.path}: --topic must name the depth images; topics: {_listed(images)}"
            )
        return depth[0]

    def _info_topic(self, topics: dict[str, str]) -> str:
        """Return the topic of the camera: beside the images, else the only one."""
        infos = [name for name, kind in topics.items() if kind == INFO]
        image = self.topic.removesuffix("/compressedDepth")
        for wanted in (f"{image.rpartition('/')[0]}/camera_info", f"{image}/camera_info"):
            if wanted in infos:
                return wanted
        if len(infos) != 1:
            raise InputError(
                f"{self.path}: no CameraInfo beside {self.topic}, only {_listed(infos)}: give the "
                "intrinsics by --camera FILE"
            )
        return infos[0]

    def _messages(self, topics: Iterable[str]) -> Iterator[tuple[str, Any]]:
        """Yield topic and decoded message."""
        factory = load_ros("mcap_ros2.decoder").DecoderFactory()
        with self.path.open("rb") as file:
            stream = _reader(file, factory).iter_decoded_messages(topics)
            while True:
                with self._damage():
                    item = next(stream, None)
                if item is None:
                    return
                yield item[1].topic, item[3]

    @contextmanager
    def _damage(self) -> Iterator[None]:
        """Raise all faults of the decoders as one kind: they check little themselves."""
        try:
            yield
        except InputError:
            raise
        except Exception as error:
            fault = " ".join(str(error).split()) or type(error).__name__
            raise InputError(f"{self.path}: damaged, or no ROS 2 messages ({fault})") from error


def _recording_file(path: Path) -> Path:
    """Return the file of a recording, which may be a folder with one."""
    if not path.is_dir():
        return path
    files = [str(file) for file in path.glob(f"*{SUFFIX}")]
    if not files:
        raise InputError(f"{path} is a folder without a recording (*{SUFFIX}): name a file")
    if len(files) > 1:
        raise InputError(
            f"{path}: the folder has {len(files)} recordings (*{SUFFIX}), name one: "
            f"{_listed(files)}"
        )
    return Path(files[0])


def _reader(file: Any, *factories: Any) -> Any:
    return load_ros("mcap.reader").SeekingReader(
        file, validate_crcs=True, decoder_factories=factories, record_size_limit=MAX_RECORD_BYTES
    )


def _depth(message: Any) -> NDArray[np.float32]:
    """Return the depth (H, W) float32, m, of an image message."""
    if hasattr(message, "format"):
        return _compressed_depth(message.format, bytes(message.data))
    if message.encoding not in DTYPES:
        raise InputError(
            f"its encoding is {message.encoding!r}, expected {', '.join(DTYPES)} for depth"
        )
    height, width, step = message.height, message.width, message.step
    check_image_size(width, height)
    kind = np.dtype(DTYPES[message.encoding]).newbyteorder(">" if message.is_bigendian else "<")
    data = np.frombuffer(bytes(message.data), np.uint8)
    if step < width * kind.itemsize or len(data) != height * step:
        raise InputError(
            f"it has {len(data)} bytes in rows of {step}, which are no {width}x{height} px of "
            f"{message.encoding}"
        )
    raw = data.reshape(height, step)[:, : width * kind.itemsize].copy().view(kind)
    if raw.dtype.kind == "u":
        return metres_from_units(raw, 1.0)
    return _without_gaps(raw)


def _colour_of(depth: Any, colour: Any) -> NDArray[np.uint8] | None:
    """Return the colour (H, W, 3) of a depth image; None if the images were not taken together."""
    if colour.encoding not in COLOURS:
        raise InputError(
            f"its colour image has encoding {colour.encoding!r}, expected {', '.join(COLOURS)}"
        )
    taken, beside = depth.header.stamp, colour.header.stamp
    if (taken.sec, taken.nanosec) != (beside.sec, beside.nanosec):
        return None
    if (colour.width, colour.height) != (depth.width, depth.height):
        raise InputError(
            f"its colour image has {colour.width}x{colour.height} px, expected the "
            f"{depth.width}x{depth.height} px of the depth"
        )
    channels = len(colour.encoding) - 1  # of rgb8: 3, of rgba8: 4
    rows = np.frombuffer(bytes(colour.data), np.uint8).reshape(colour.height, colour.step)
    pixels = rows[:, : channels * colour.width].reshape(colour.height, colour.width, channels)
    return pixels[..., COLOURS[colour.encoding]]


def _compressed_depth(form: str, data: bytes) -> NDArray[np.float32]:
    """Decode an image of compressed_depth_image_transport: a PNG of mm, or of inverse depth."""
    if "compressedDepth" not in form or "rvl" in form.lower():
        raise InputError(f"its format is {form!r}, expected 16UC1 or 32FC1 compressedDepth as PNG")
    if len(data) <= COMPRESSED_HEAD.size:
        raise InputError(f"it has {len(data)} bytes, too few for a compressedDepth image")
    _, scale, offset = COMPRESSED_HEAD.unpack_from(data)
    raw = decode_depth(data[COMPRESSED_HEAD.size :])
    if not form.startswith("32FC1"):
        return metres_from_units(raw, 1.0)
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        depth = scale / (raw.astype(np.float64) - offset)
    return _without_gaps(np.where(raw > 0, depth, 0.0))


def _without_gaps(depth: NDArray[np.floating]) -> NDArray[np.float32]:
    """Return readings as they are, and 0 where there is none (NaN, infinity)."""
    with np.errstate(over="ignore"):
        metres = depth.astype(np.float32)
    return np.where(np.isfinite(metres), metres, np.float32(0.0))


def _undistorted(
    info: Any, depth: NDArray[np.float32], *, rectified: bool
) -> tuple[CameraFile, NDArray[np.float32]]:
    """Return the pinhole camera of a CameraInfo, and the image that it would have taken.

    A rectified image is already that of the pinhole camera `p`; `k` and `d` are of the raw image.
    """
    height, width = depth.shape
    if (info.height, info.width) != (height, width):
        raise InputError(
            f"it is {width}x{height} px, but CameraInfo is of {info.width}x{info.height} px"
        )
    if rectified and info.p[0] > 0.0:
        P = np.array(info.p, dtype=np.float64).reshape(3, 4)
        name = "CameraInfo p (row-major)"
        return CameraFile(intrinsics_from_matrix(P[:, :3], width, height, name)), depth
    K = np.array(info.k, dtype=np.float64).reshape(3, 3)
    camera: CameraIntrinsics = intrinsics_from_matrix(K, width, height, "CameraInfo k (row-major)")
    lens = np.array(info.d, dtype=np.float64)
    if lens.any():
        if info.distortion_model not in PINHOLE or len(lens) not in (4, 5, 8, 12, 14):
            raise InputError(f"cannot correct the distortion model {info.distortion_model!r}")
        maps = cv2.initUndistortRectifyMap(K, lens, None, K, (width, height), cv2.CV_32FC1)  # pyright: ignore[reportCallIssue, reportArgumentType]
        depth = cv2.remap(depth, *maps, cv2.INTER_NEAREST).astype(np.float32)
    return CameraFile(camera), depth


def _listed(names: Iterable[str]) -> str:
    return ", ".join(sorted(names)) or "none"
