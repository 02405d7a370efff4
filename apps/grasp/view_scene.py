"""Compute what a 3D view of a frame shows: its direction, and the readings near the objects."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..scene_picture import colour_of

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from .jaw_frame import GraspedFrame

TABLE_POINT = (196, 200, 206)
"""Colour of readings that are no object."""
MAX_POINTS = 14000
"""Maximum number of drawn points."""
AROUND = 0.09
"""Width of the surroundings of the objects that the 3D view shows, m."""
AZIMUTH, ELEVATION = np.radians(40.0), np.radians(32.0)
"""Direction of the 3D view: turned from the camera about the vertical, above the horizontal."""


def view_axes(found: GraspedFrame) -> NDArray[np.float64]:
    """Return right, up and towards the viewer, (3, 3): from the camera's side and above."""
    scene = found.scene
    if scene.support is not None:
        up = scene.support.normal
    else:
        up = np.array([0, 0, 1.0] if scene.reference_frame == "world" else [0, -1.0, 0])
    camera = np.asarray(found.scene_in_camera.inv().as_matrix(), dtype=np.float64)
    towards = -camera[:3, 2] - (-camera[:3, 2] @ up) * up
    if np.linalg.norm(towards) < 0.1:
        # The camera looks straight down: the lower edge of the image is in front.
        towards = camera[:3, 1] - (camera[:3, 1] @ up) * up
    towards /= np.linalg.norm(towards)
    turned = np.cos(AZIMUTH) * towards + np.sin(AZIMUTH) * np.cross(up, towards)
    eye = np.cos(ELEVATION) * turned + np.sin(ELEVATION) * up
    right = np.cross(up, eye).astype(np.float64)
    right /= np.linalg.norm(right)
    return np.stack([right, np.cross(eye, right), eye]).astype(np.float64)


def viewed_points(found: GraspedFrame) -> NDArray[np.float64]:
    """Return the points (N, 3) that the view must contain: of objects with a grasp, else of all.

    Objects without a grasp may be metres away.
    """
    items = found.scene.objects
    chosen = [item for item in items if item.label in found.best_ranks] or items
    return np.concatenate([np.zeros((0, 3)), *(item.points for item in chosen)])


def nearby_points(found: GraspedFrame) -> tuple[NDArray[np.float64], NDArray[np.uint8]]:
    """Return readings near the objects (N, 3) and their colours (N, 3)."""
    frame, scene = found.frame, found.scene
    valid = frame.valid
    points = found.scene_in_camera.inv().apply(frame.points()[valid])
    labels = scene.segmentation.labels[valid]
    shown = viewed_points(found)
    if len(shown):
        low, high = shown.min(axis=0) - AROUND, shown.max(axis=0) + AROUND
        near = ((points > low) & (points < high)).all(axis=1)
        points, labels = points[near], labels[near]
    step = max(-(-len(points) // MAX_POINTS), 1)
    points, labels = points[::step], labels[::step]
    palette = np.array([TABLE_POINT, *(colour_of(k) for k in range(1, labels.max(initial=0) + 1))])
    return points, np.round(0.9 * palette[np.maximum(labels, 0)]).astype(np.uint8)
