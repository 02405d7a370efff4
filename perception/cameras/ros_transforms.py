"""Chains of ROS 2 transforms from the world to the frame of a camera."""

from __future__ import annotations

import logging
from typing import Any

from scipy.spatial.transform import RigidTransform, Rotation

from .ros_frames import WORLD

_log = logging.getLogger("eyehand")


class TransformTree:
    """The last transform of each coordinate frame to its parent."""

    def __init__(self) -> None:
        self._parents: dict[str, tuple[str, Any]] = {}
        self._warned = False

    def add(self, message: Any) -> None:
        """Add the transforms of a TFMessage. A later one of the same frame replaces the earlier."""
        for one in message.transforms:
            self._parents[_name(one.child_frame_id)] = _name(one.header.frame_id), one.transform

    def world_pose(self, frame: str) -> RigidTransform | None:
        """Return the pose of a frame in the world; None if no chain of transforms leads there.

        A chain that leads to another frame is named in the log, once.
        """
        name, passed = _name(frame), {WORLD}
        pose = RigidTransform.identity()
        while name in self._parents and name not in passed:
            passed.add(name)
            name, step = self._parents[name]
            t, q = step.translation, step.rotation
            turn = Rotation.from_quat([q.x, q.y, q.z, q.w])
            pose = RigidTransform.from_components([t.x, t.y, t.z], turn) * pose
        if name == WORLD and len(passed) > 1:
            return pose
        if len(passed) > 1 and not self._warned:
            self._warned = True
            _log.warning(
                "the transforms of %s lead to %s, not to %s: the scene is in the camera frame; "
                "give the camera's pose by a camera file",
                *(frame, name, WORLD),
            )
        return None


def _name(frame: str) -> str:
    """Return the name of a frame without the slash that ROS 1 put before it."""
    return frame.removeprefix("/")
