"""Draw a grasp into a picture: palm, fingers, thumb, and the approach direction.

Of a gripper, both jaws have the colour of fingers.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import cv2
import numpy as np
from scipy.spatial.transform import RigidTransform, Rotation

from ..scene_picture import SUBPIXEL

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from eyehand.grasping import GraspPlan
    from eyehand.perception import DepthFrame

APPROACH_LINE = 0.06
"""Length of the approach line behind the palm, m."""
MIN_FINGER_LINE = 0.075
"""Minimum length of the drawn fingers, m."""
DARK, BRIGHT, THUMB = (20, 20, 20), (255, 255, 255), (255, 176, 0)
LINE_WIDTH = 4
"""Line width in an image 1280 px wide, px."""


def draw_grasp(
    picture: NDArray[np.uint8],
    frame: DepthFrame,
    plan: GraspPlan,
    T_world_palm: RigidTransform | None = None,
) -> None:
    """Draw a grasp into a picture of a frame, in place. The thumb has its own colour.

    Parameters
    ----------
    picture
        Picture (H', W', 3) of the frame, possibly enlarged.
    frame
        The depth frame with its camera pose.
    plan
        The grasp.
    T_world_palm
        Pose of the palm, or of the tool frame of a gripper; default: the preferred pose of the
        plan.
    """
    if not plan or frame.T_world_camera is None:
        return
    if T_world_palm is None:
        T_world_palm = preferred_palm(plan)
    half = plan.opening / 2
    jaws = plan.geometry is None
    # The frame of a gripper lies between its fingertips, that of a hand in its palm.
    palm = -MIN_FINGER_LINE if jaws else 0.0
    reach = 0.0 if jaws else max(plan.standoff, MIN_FINGER_LINE)
    strokes = (
        ([[0, 0, palm - APPROACH_LINE], [0, 0, palm]], BRIGHT),
        ([[half, 0, palm], [-half, 0, palm], [-half, 0, reach]], BRIGHT),
        ([[0, 0, palm], [half, 0, palm], [half, 0, reach]], BRIGHT if jaws else THUMB),
    )
    zoom = picture.shape[1] / frame.depth.shape[1]
    T_camera_palm = frame.T_world_camera.inv() * T_world_palm
    thick = max(round(LINE_WIDTH * picture.shape[1] / 1280), 1)
    lines = []
    for points, colour in strokes:
        pixels = frame.intrinsics.project(T_camera_palm.apply(np.array(points, dtype=float)))
        if not np.isfinite(pixels).all():
            return
        enlarged = np.clip((pixels + 0.5) * zoom - 0.5, -1e4, 1e4)
        lines.append((np.round(enlarged * (1 << SUBPIXEL)).astype(np.int32), colour))
    for fixed, _ in lines:
        cv2.polylines(picture, [fixed], False, DARK, thick + 3, cv2.LINE_AA, SUBPIXEL)
    for fixed, colour in lines:
        cv2.polylines(picture, [fixed], False, colour, thick, cv2.LINE_AA, SUBPIXEL)


def preferred_palm(plan: GraspPlan) -> RigidTransform:
    """Return the preferred palm pose of a plan: z out of the palm, x from fingers to thumb.

    Of a gripper it is the pose of the tool frame.
    """
    z = plan.palm / np.linalg.norm(plan.palm)
    x = plan.closing - (plan.closing @ z) * z
    x /= np.linalg.norm(x)
    turn = Rotation.from_matrix(np.column_stack([x, np.cross(z, x), z]))
    if plan.geometry is None:
        return RigidTransform.from_components(plan.tasks[0].point, turn)
    return RigidTransform.from_components(plan.geometry.centre - plan.standoff * z, turn)
