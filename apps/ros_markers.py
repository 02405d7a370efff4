"""Scenes and grasps as ROS 2 messages that Foxglove and RViz show."""

from __future__ import annotations

from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

import numpy as np
from scipy.spatial.transform import RigidTransform

from eyehand.errors import InputError
from eyehand.perception.cameras import RosWriter, ros_header, ros_pose, ros_writer, write_ros_frame
from eyehand.perception.superquadric import mesh

from .grasp.grasp_glyph import preferred_palm
from .output_files import make_folder
from .scene_json import fit_parts
from .scene_picture import colour_of

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping
    from pathlib import Path

    from numpy.typing import NDArray

    from eyehand.grasping import GraspPlan
    from eyehand.perception import DepthFrame, Scene, SceneObject

ADD, DELETE_ALL = 0, 3
TRIANGLES, TEXT = 11, 9
"""Actions and types of visualization_msgs/Marker."""
RESOLUTION = 24
"""Points around a drawn solid."""
OPACITY = 0.6
TEXT_HEIGHT = 0.02
"""Height of the letters, m."""
DEPTH_TOPIC, MARKER_TOPIC, GRASP_TOPIC = "/camera/depth", "/eyehand/scene", "/eyehand/grasps"
"""Topics of the depth image, the solids, and the palm or tool poses at the grasps."""


def check_mcap_name(path: Path | None) -> None:
    """Check the name of the file of --mcap.

    Raises
    ------
    InputError
        If it does not end in .mcap.
    """
    if path is not None and path.suffix.lower() != ".mcap":
        raise InputError(f"--mcap must name an .mcap file, got {path}")


@contextmanager
def scene_writer(path: Path | None) -> Iterator[RosWriter | None]:
    """Open a recording for `write_scene`, or return None without a path.

    Raises
    ------
    InputError
        If the path does not name an .mcap file, cannot be written, or the extra `ros` is absent.
    """
    if path is None:
        yield None
        return
    check_mcap_name(path)
    make_folder(path.parent)
    with ros_writer(path) as writer:
        yield writer


def write_scene(
    writer: RosWriter,
    frame: DepthFrame,
    scene: Scene,
    plans: Mapping[int, GraspPlan],
    seconds: float,
    colours: Mapping[int, int] | None = None,
) -> None:
    """Write a depth image, the solids found in it, their grasps, and the pose of the camera.

    Parameters
    ----------
    writer
        The recording.
    frame, scene
        The image and its scene. Coordinates are in the frame `world`, or `camera` if its pose is
        unknown.
    plans
        Grasps by object label. Rejected ones are left out.
    seconds
        Time of the image, s.
    colours
        Colour number of each object by its label; default: the label.
    """
    write_ros_frame(writer, frame, seconds, DEPTH_TOPIC)
    head = ros_header(seconds, scene.reference_frame)
    markers = [_marker(head, "clear", 0, TEXT) | {"action": DELETE_ALL}]
    for item in scene.objects:
        shade = colour_of((colours or {}).get(item.label, item.label)) / 255.0
        markers += _object_markers(head, item, shade)
    writer.write(MARKER_TOPIC, "visualization_msgs/MarkerArray", {"markers": markers}, seconds)
    poses = [ros_pose(preferred_palm(plan)) for plan in plans.values() if plan]
    writer.write(GRASP_TOPIC, "geometry_msgs/PoseArray", {"header": head, "poses": poses}, seconds)


def triangle_marker(
    head: dict[str, Any],
    name: str,
    number: int,
    triangles: NDArray[np.floating],
    colours: NDArray[np.floating],
) -> dict[str, Any]:
    """Return a marker of triangles.

    Parameters
    ----------
    head
        Time and coordinate frame.
    name, number
        Namespace and number, which identify the marker.
    triangles
        Corners (T, 3, 3), m.
    colours
        RGBA colour of all, (4,), or of each corner, (3 T, 4), in [0, 1].
    """
    marker = _marker(head, name, number, TRIANGLES)
    marker["scale"] = _vector(np.ones(3))
    marker["points"] = [_vector(corner) for corner in triangles.reshape(-1, 3)]
    if colours.ndim == 1:
        marker["color"] = _colour(colours)
    else:
        marker["colors"] = [_colour(one) for one in colours]
    return marker


def _object_markers(
    head: dict[str, Any], item: SceneObject, shade: NDArray[np.float64]
) -> list[dict[str, Any]]:
    """Return the solids of an object and its label."""
    markers = []
    parts = fit_parts(item.fit) if item.fit else ()
    for number, part in enumerate(parts):
        vertices, faces = mesh(part, RESOLUTION)
        rgba = np.append(shade, OPACITY)
        name = f"object {item.label}"
        markers.append(triangle_marker(head, name, number, vertices[faces], rgba))
    label = _marker(head, f"label {item.label}", 0, TEXT)
    top = item.points.mean(axis=0) + np.array([0.0, 0.0, 2 * TEXT_HEIGHT])
    label["pose"] = ros_pose(RigidTransform.from_translation(top))
    label["scale"] = _vector(np.full(3, TEXT_HEIGHT))
    label["color"] = _colour(np.array([0.1, 0.1, 0.1, 1.0]))
    label["text"] = f"{item.label} {parts[0].kind if parts else ''}".strip()
    return [*markers, label]


def _marker(head: dict[str, Any], name: str, number: int, kind: int) -> dict[str, Any]:
    """Return a marker at the origin. The writer fills the other fields with zeros."""
    return {
        "header": head,
        "ns": name,
        "id": number,
        "type": kind,
        "action": ADD,
        "pose": ros_pose(RigidTransform.identity()),
    }


def _vector(values: NDArray[np.floating]) -> dict[str, float]:
    return dict(zip("xyz", map(float, values), strict=True))


def _colour(values: NDArray[np.floating]) -> dict[str, float]:
    return dict(zip("rgba", map(float, values), strict=True))
