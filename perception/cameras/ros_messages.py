"""ROS 2 messages in MCAP files, written without ROS.

The definitions are those of ROS 2 (common_interfaces, geometry2). Only messages that eyehand writes
are here: a recording that is read brings its own definitions.
"""

from __future__ import annotations

import importlib
import re
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from scipy.spatial.transform import RigidTransform

from eyehand.errors import InputError

from ..io.atomic_write import atomic_write

HEADER = "std_msgs/Header header\n"
DEFINITIONS = {
    "builtin_interfaces/Time": "int32 sec\nuint32 nanosec",
    "builtin_interfaces/Duration": "int32 sec\nuint32 nanosec",
    "std_msgs/Header": "builtin_interfaces/Time stamp\nstring frame_id",
    "std_msgs/ColorRGBA": "float32 r\nfloat32 g\nfloat32 b\nfloat32 a",
    "geometry_msgs/Point": "float64 x\nfloat64 y\nfloat64 z",
    "geometry_msgs/Vector3": "float64 x\nfloat64 y\nfloat64 z",
    "geometry_msgs/Quaternion": "float64 x\nfloat64 y\nfloat64 z\nfloat64 w",
    "geometry_msgs/Pose": "geometry_msgs/Point position\ngeometry_msgs/Quaternion orientation",
    "geometry_msgs/PoseArray": f"{HEADER}geometry_msgs/Pose[] poses",
    "geometry_msgs/Transform": (
        "geometry_msgs/Vector3 translation\ngeometry_msgs/Quaternion rotation"
    ),
    "geometry_msgs/TransformStamped": (
        f"{HEADER}string child_frame_id\ngeometry_msgs/Transform transform"
    ),
    "tf2_msgs/TFMessage": "geometry_msgs/TransformStamped[] transforms",
    "sensor_msgs/Image": (
        f"{HEADER}uint32 height\nuint32 width\nstring encoding\nuint8 is_bigendian\nuint32 step\n"
        "uint8[] data"
    ),
    "sensor_msgs/CompressedImage": f"{HEADER}string format\nuint8[] data",
    "sensor_msgs/RegionOfInterest": (
        "uint32 x_offset\nuint32 y_offset\nuint32 height\nuint32 width\nbool do_rectify"
    ),
    "sensor_msgs/CameraInfo": (
        f"{HEADER}uint32 height\nuint32 width\nstring distortion_model\nfloat64[] d\n"
        "float64[9] k\nfloat64[9] r\nfloat64[12] p\nuint32 binning_x\nuint32 binning_y\n"
        "sensor_msgs/RegionOfInterest roi"
    ),
    "sensor_msgs/JointState": (
        f"{HEADER}string[] name\nfloat64[] position\nfloat64[] velocity\nfloat64[] effort"
    ),
    "visualization_msgs/UVCoordinate": "float32 u\nfloat32 v",
    "visualization_msgs/MeshFile": "string filename\nuint8[] data",
    "visualization_msgs/Marker": (
        f"{HEADER}string ns\nint32 id\nint32 type\nint32 action\ngeometry_msgs/Pose pose\n"
        "geometry_msgs/Vector3 scale\nstd_msgs/ColorRGBA color\n"
        "builtin_interfaces/Duration lifetime\nbool frame_locked\ngeometry_msgs/Point[] points\n"
        "std_msgs/ColorRGBA[] colors\nstring texture_resource\n"
        "sensor_msgs/CompressedImage texture\nvisualization_msgs/UVCoordinate[] uv_coordinates\n"
        "string text\nstring mesh_resource\nvisualization_msgs/MeshFile mesh_file\n"
        "bool mesh_use_embedded_materials"
    ),
    "visualization_msgs/MarkerArray": "visualization_msgs/Marker[] markers",
}
"""Fields of the messages, by type."""
SEPARATOR = "=" * 80


def load_ros(module: str) -> Any:
    """Import a module of the extra `ros`.

    Raises
    ------
    InputError
        If the extra is not installed.
    """
    try:
        return importlib.import_module(module)
    except ImportError as error:
        raise InputError(
            f"ROS 2 recordings need the package {module.split('.')[0].replace('_', '-')}: pip "
            "install 'eyehand[ros]'"
        ) from error


class RosWriter:
    """A recording that is being written. Messages are dicts with the fields of their type."""

    def __init__(self, writer: Any) -> None:
        self._writer = writer
        self._schemas: dict[str, Any] = {}

    def write(self, topic: str, kind: str, message: dict[str, Any], seconds: float) -> None:
        """Write a message of a type in `DEFINITIONS`, with its time in s."""
        if kind not in self._schemas:
            package, name = kind.split("/")
            text = definition(kind)
            self._schemas[kind] = self._writer.register_msgdef(f"{package}/msg/{name}", text)
        stamp = round(1e9 * seconds)
        self._writer.write_message(topic, self._schemas[kind], message, stamp, stamp)


@contextmanager
def ros_writer(path: Path) -> Iterator[RosWriter]:
    """Open an MCAP file for ROS 2 messages. An error discards the file.

    Raises
    ------
    InputError
        If the extra `ros` is not installed, or the file cannot be written.
    """
    kind = load_ros("mcap_ros2.writer").Writer
    with atomic_write(path) as temporary, temporary.open("wb") as file:
        writer = kind(file)
        yield RosWriter(writer)
        writer.finish()


def definition(kind: str) -> str:
    """Return the text of a type with those of its fields, as ROS 2 stores it in a recording."""
    needed = [kind]
    for one in needed:
        fields = re.findall(r"^([a-z_0-9]+/\w+)", DEFINITIONS[one], re.MULTILINE)
        needed += [field for field in dict.fromkeys(fields) if field not in needed]
    parts = [DEFINITIONS[kind], *(f"MSG: {one}\n{DEFINITIONS[one]}" for one in needed[1:])]
    return f"\n{SEPARATOR}\n".join(parts)


def ros_header(seconds: float, frame: str) -> dict[str, Any]:
    """Return a header with a time in s and the name of a coordinate frame."""
    whole, rest = divmod(round(1e9 * seconds), 10**9)
    return {"stamp": {"sec": whole, "nanosec": rest}, "frame_id": frame}


def ros_pose(pose: RigidTransform) -> dict[str, Any]:
    """Return a geometry_msgs/Pose."""
    return {
        "position": _named("xyz", pose.translation),
        "orientation": _named("xyzw", pose.rotation.as_quat()),
    }


def ros_transform(seconds: float, parent: str, child: str, pose: RigidTransform) -> dict[str, Any]:
    """Return a geometry_msgs/TransformStamped that maps from `child` to `parent`."""
    return {
        "header": ros_header(seconds, parent),
        "child_frame_id": child,
        "transform": {
            "translation": _named("xyz", pose.translation),
            "rotation": _named("xyzw", pose.rotation.as_quat()),
        },
    }


def _named(names: str, values: Any) -> dict[str, float]:
    return dict(zip(names, map(float, values), strict=True))
