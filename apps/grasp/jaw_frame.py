"""Perceive a frame and plan the grasps of a parallel gripper in it."""

from __future__ import annotations

import time
from dataclasses import dataclass, replace

from scipy.spatial.transform import RigidTransform

from eyehand.errors import InputError
from eyehand.grasping import (
    DepthCorrection,
    Grasp,
    GraspList,
    JawOptions,
    ParallelHand,
    correct_depth,
    plan_grasps,
)
from eyehand.perception import DepthFrame, Scene, perceive


# Arrays have no truth value: equality is identity.
@dataclass(frozen=True, eq=False)
class GraspedFrame:
    """A depth frame, the scene in it, and the grasps of a gripper."""

    source: str
    """Where the frame is from."""
    frame: DepthFrame
    """The depth frame, corrected if there is a correction."""
    scene: Scene
    """Support plane and objects."""
    hand: ParallelHand
    """The gripper."""
    grasps: GraspList
    """All grasps, the most probable first."""
    top: int
    """Number of grasps that are reported."""
    correction: DepthCorrection | None
    """How the depth was corrected from the height of the table; None without that height."""
    correct_seconds: float
    """Duration of that correction, s."""

    @property
    def shown(self) -> tuple[Grasp, ...]:
        """The reported grasps, the most probable first."""
        return self.grasps[: self.top]

    @property
    def best_ranks(self) -> dict[int, int]:
        """Label of an object → rank of its best grasp, from 1."""
        ranks: dict[int, int] = {}
        for rank, grasp in enumerate(self.grasps, 1):
            ranks.setdefault(grasp.object_label, rank)
        return ranks

    @property
    def scene_in_camera(self) -> RigidTransform:
        """Pose of the scene's frame in the camera."""
        if self.scene.reference_frame == "camera" or self.frame.T_world_camera is None:
            return RigidTransform.identity()
        return self.frame.T_world_camera.inv()

    def why_none(self, label: int) -> str:
        """Return why an object has no grasp."""
        reasons = self.grasps.rejected.get(label, {})
        most = sorted(((n, name) for name, n in reasons.items() if n), reverse=True)[:2]
        if not most:
            return "no candidate is probable enough"
        return ", ".join(
            f"{name.replace('_', ' ')}{f' ({n} candidates)' if n > 1 else ''}" for n, name in most
        )


def grasp_frame(
    frame: DepthFrame,
    hand: ParallelHand,
    options: JawOptions,
    *,
    source: str = "",
    table_height: float | None = None,
    top: int = 10,
) -> GraspedFrame:
    """Perceive a frame and plan the grasps of a gripper.

    Parameters
    ----------
    frame
        The depth frame.
    hand, options
        The gripper and the options of planning.
    source
        Where the frame is from, for messages.
    table_height
        Height of the table in the world, m, from which scale and tilt of the depth are corrected.
    top
        Number of grasps that are reported.

    Raises
    ------
    InputError
        If the depth cannot be corrected from the height of the table.
    """
    correction = None
    began = time.perf_counter()
    if table_height is not None:
        if frame.T_world_camera is None:
            raise InputError(
                "--table-height needs the camera's pose: T_world_camera in the camera file, or "
                "--camera-pose"
            )
        frame, correction = correct_depth(frame, table_height)
        if not correction:
            raise InputError(f"--table-height {table_height:g} does not fit: {correction.reason}")
    seconds = time.perf_counter() - began
    scene = perceive(frame)
    grasps = plan_grasps(scene, hand, options)
    if correction is not None and correction.doubtful:
        doubt = f"the scale of the depth changed by {100 * (correction.scale - 1):+.1f} %"
        forbidden = [
            replace(one, safe=False, forbidden_by=(*one.forbidden_by, doubt)) for one in grasps
        ]
        grasps = replace(grasps, grasps=tuple(forbidden))
    return GraspedFrame(source, frame, scene, hand, grasps, top, correction, seconds)
