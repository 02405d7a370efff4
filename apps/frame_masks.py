"""Parts of a depth frame that the user masks: an image, the robot at its posture, a region."""

from __future__ import annotations

import functools
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import numpy as np
from cyclopts import Parameter

from eyehand.errors import InputError
from eyehand.perception import (
    DepthFrame,
    PosedVolumes,
    mask_points,
    mask_robot,
    mask_volumes,
    volume_extents,
)
from eyehand.perception.io import decode_mask, naming, pose_from_json, read_bytes

from .console import say

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray
    from scipy.spatial.transform import RigidTransform

    from eyehand.control import LinkVolumes

RECTANGLE, BOX, POSE = 4, 6, 7
"""Numbers of an image rectangle, a box, and a pose."""
MAX_JOINT = 13.0
"""Maximum joint position, rad: two turns. A larger one is in degrees."""


def split_numbers(_hint: Any, tokens: Sequence[Any]) -> list[float]:
    """Convert tokens to numbers. One token may hold several, separated by blanks or commas."""
    words = [word for token in tokens for word in token.value.replace(",", " ").split()]
    return [float(word) for word in words]


Numbers = Annotated[list[float] | None, Parameter(converter=split_numbers)]
"""Option of several numbers, quoted as one argument or not."""


@dataclass(frozen=True)
class FrameMasks:
    """Options of the commands that read a depth frame: readings that count as no readings."""

    mask: Path | None = None
    """PNG image of the frame's size. Pixels that are not black are masked."""
    robot: Path | None = None
    """MJCF or URDF file of the robot. What the camera sees of it is masked. The camera's pose must
    be known."""
    q: Numbers = None
    """Joint positions of the robot, rad (m for slide joints), in the order of its file. Joints
    without a number, such as those of a hand, stay at the file's home posture."""
    robot_pose: Numbers = None
    """Pose of the robot's base in the world: x y z in m, quaternion w x y z. Default: the
    origin."""
    camera_pose: Numbers = None
    """Pose of the camera in the world: x y z in m, quaternion w x y z of its optical frame (x
    right, y down, z forward). It replaces the pose in the frame's files."""
    region: Numbers = None
    """Part of the frame that is segmented: u0 v0 u1 v1 in px, or x0 y0 z0 x1 y1 z1 in m, in the
    world frame if the camera's pose is known, else in the camera frame. The table must be in it."""

    def __post_init__(self) -> None:
        if (self.robot is None) != (self.q is None):
            raise InputError("--robot needs --q, and --q needs --robot")
        if self.q and max(map(abs, self.q)) > MAX_JOINT:
            raise InputError(f"--q must be in rad (m for slide joints), got {self.q}")
        if self.robot_pose is not None and self.robot is None:
            raise InputError("--robot-pose needs --robot")
        if self.region is not None:
            _check_region(self.region)

    def applied(self, frame: DepthFrame) -> DepthFrame:
        """Return a frame without the masked readings, and with the camera's given pose.

        Raises
        ------
        InputError
            If a file cannot be used, the robot's place is unknown, or no reading is left.
        """
        if self.camera_pose is not None:
            frame = replace(frame, T_world_camera=_pose(self.camera_pose, "--camera-pose"))
        if self.mask is not None:
            frame = mask_robot(frame, _read_mask(self.mask, frame.depth.shape))
        if self.robot is not None:
            before = np.count_nonzero(frame.depth)
            frame = mask_volumes(frame, self._robot_volumes(frame))
            share = 100 * (1 - np.count_nonzero(frame.depth) / before)
            say(
                f"the robot masks {share:.1f} % of the readings"
                if share
                else "warning: no reading lies on the robot: check --q and the poses"
            )
        return frame if self.region is None else _within(frame, self.region)

    def _robot_volumes(self, frame: DepthFrame) -> PosedVolumes:
        if frame.T_world_camera is None:
            raise InputError(
                "--robot needs the camera's pose: T_world_camera in the camera file, or "
                "--camera-pose"
            )
        assert self.robot is not None
        assert self.q is not None
        links, extents = _load_robot(self.robot, len(self.q))
        poses = links.poses(self.q)
        if self.robot_pose is not None:
            poses = _pose(self.robot_pose, "--robot-pose").as_matrix() @ poses
        return PosedVolumes(extents, poses)


@functools.cache
def _load_robot(path: Path, given: int) -> tuple[LinkVolumes, NDArray[np.float64]]:
    """Load a robot, and report the joints that stay at home when `given` numbers are given."""
    # Only this option needs MuJoCo.
    from eyehand.control import LinkVolumes

    links = LinkVolumes(path)
    if links.joint_names[given:]:
        say(f"--q: {', '.join(links.joint_names[given:])} stay at the home posture")
    return links, volume_extents(links.points)


def _pose(numbers: list[float], name: str) -> RigidTransform:
    if len(numbers) != POSE or not np.isfinite(numbers).all():
        raise InputError(
            f"{name} needs {POSE} finite numbers, x y z qw qx qy qz, got {len(numbers)}: {numbers}"
        )
    return pose_from_json({"translation_m": numbers[:3], "quat_wxyz": numbers[3:]}, name)


def _read_mask(path: Path, shape: tuple[int, ...]) -> NDArray[np.bool_]:
    data = read_bytes(path)
    with naming(path):
        mask = decode_mask(data)
        if mask.shape != shape:
            raise InputError(
                f"the mask is {mask.shape[1]}x{mask.shape[0]} px, expected {shape[1]}x{shape[0]} px"
            )
    return mask


def _check_region(region: list[float]) -> None:
    half = len(region) // 2
    if len(region) not in (RECTANGLE, BOX) or not np.isfinite(region).all():
        raise InputError(
            "--region needs 4 numbers u0 v0 u1 v1, px, or 6 numbers x0 y0 z0 x1 y1 z1, m, "
            f"got {region}"
        )
    if not all(low < high for low, high in zip(region[:half], region[half:], strict=True)):
        raise InputError(f"--region needs the lower corner before the upper one, got {region}")


def _within(frame: DepthFrame, region: list[float]) -> DepthFrame:
    """Return a frame with the readings in a region only."""
    if len(region) == RECTANGLE:
        low_u, low_v, high_u, high_v = region
        width, height = frame.intrinsics.width, frame.intrinsics.height
        if min(low_u, low_v) < 0 or high_u > width or high_v > height:
            raise InputError(
                f"--region must lie in the image of {width} x {height} px, got {region}"
            )
        u, v = np.arange(width), np.arange(height)
        return frame.without(
            ~(((low_u <= u) & (u < high_u)) & ((low_v <= v) & (v < high_v))[:, None])
        )
    low, high = np.array(region[:3]), np.array(region[3:])
    return mask_points(frame, lambda p: np.asarray(((p < low) | (p > high)).any(axis=1)))
