"""Validate a perceived scene before the robot acts on it."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from eyehand.perception.segmentation import MAX_LEVEL_TILT

if TYPE_CHECKING:
    from eyehand.perception import DepthFrame, Scene, SupportPlane

    from .tray import Tray

MIN_VALID_SHARE = 0.4
"""Minimum share of pixels with a reading; 0.8 to 0.9 is usual. With fewer readings objects break
into pieces too small to be separated from noise, and the table looks empty."""
MAX_HEIGHT_DIFFERENCE = 0.3
"""Maximum height difference of the perceived table and the tray's floor, m. A larger one belongs to
another surface, such as the floor of the room."""
MIN_HEIGHT, MAX_HEIGHT = 0.01, 0.5
"""Heights above the table between which readings belong to an object on it, m. Lower readings may
be noise, higher ones a lamp or a person."""
NOISE_SIGMAS = 6.0
"""Height of the noise above the table, in standard deviations of the table's own readings."""
GRID_CELL = 0.03
"""Side of the square grid cells in which unexplained readings are summed, m; the size of a small
object."""
MIN_UNEXPLAINED_AREA = 1e-4
"""Unexplained area in one cell that indicates an object, m². Flying pixels over an empty table sum
up to 0.2 cm²; a sphere of 15 mm covers 1.8 cm²."""
REFUSED_WARNINGS = ("support_doubtful", "support_unseen", "camera", "noise", "constant")
"""Warnings about a scene with which the robot must not move: all positions may be wrong, or a large
surface in front of the support is neither an object nor an obstacle."""
WALL_MARGIN = 0.015
"""Distance from a wall of a container or of the tray within which readings belong to it, m."""
SAME_PLANE = 0.005
"""Maximum difference of the heights of one table in two images, m, at the camera's foot and at the
tray."""
UP = np.array([0.0, 0.0, 1.0])


def validate_scene(frame: DepthFrame, scene: Scene, tray: Tray, before: Scene | None = None) -> str:
    """Return the reason why the robot must not act on a scene; empty if it is valid.

    An empty scene means a clear table only if the table itself was perceived.

    Parameters
    ----------
    frame
        Depth image with its pose.
    scene
        The scene perceived in it, in the world frame.
    tray
        The tray that objects are put into.
    before
        An earlier valid scene. An image of equal readings is valid if it shows the same table. A
        camera without noise takes it from straight above, once the table is clear.
    """
    share = float(frame.valid.mean())
    if share < MIN_VALID_SHARE:
        return (
            f"no valid depth image: {share:.0%} of the pixels have a reading, "
            f"at least {MIN_VALID_SHARE:.0%} are needed"
        )
    support = scene.support
    if support is None:
        return "no table found: there is no level surface in view"
    for warning in scene.warnings:
        known = warning.kind == "constant" and _is_same_table(frame, support, tray, before)
        if warning.kind in REFUSED_WARNINGS and not known:
            return f"the scene is not reliable: {warning.message}"
    tilt = float(np.arccos(np.clip(support.normal @ UP, -1.0, 1.0)))
    if tilt > MAX_LEVEL_TILT:
        return (
            f"the perceived table tilts by {np.degrees(tilt):.1f}°, more than "
            f"{np.degrees(MAX_LEVEL_TILT):.0f}°: check the camera pose"
        )
    offset = float(support.normal @ tray.centre + support.offset)
    if abs(offset) > MAX_HEIGHT_DIFFERENCE:
        where = "below" if offset > 0 else "above"
        return f"no table found: the perceived surface lies {abs(offset):.2f} m {where} the tray"
    area = unexplained_area(frame, scene, tray) if not scene.objects else 0.0
    if area > MIN_UNEXPLAINED_AREA:
        return (
            f"the table may not be clear: readings of {1e4 * area:.0f} cm² above it belong to no "
            "segmented object"
        )
    return ""


def _is_same_table(
    frame: DepthFrame, support: SupportPlane, tray: Tray, before: Scene | None
) -> bool:
    """Return whether the table is that of an earlier scene."""
    if before is None or before.support is None or frame.T_world_camera is None:
        return False
    camera = frame.T_world_camera.translation
    places = np.array([tray.centre, camera - support.height(camera) * support.normal])
    gap = np.abs(before.support.height(places) - support.height(places))
    return bool((gap < SAME_PLANE).all())


def unexplained_area(frame: DepthFrame, scene: Scene, tray: Tray) -> float:
    """Return the maximum area of readings above the table that belong to no object.

    Parameters
    ----------
    frame
        Depth image with its pose.
    scene
        The scene perceived in it, in the world frame. A scene of another image gives 0.
    tray
        The tray. Readings in it, at its walls and above it are explained.

    Returns
    -------
    float
        Maximum area in a grid cell of side `GRID_CELL`, perpendicular to the line of sight, m².
    """
    labels, support, T_world_camera = scene.segmentation.labels, scene.support, frame.T_world_camera
    if support is None or T_world_camera is None or labels.shape != frame.depth.shape:
        return 0.0
    free = frame.valid & (labels == 0)
    points = T_world_camera.apply(frame.points()[free])
    height = support.height(points)
    noise = max(MIN_HEIGHT, NOISE_SIGMAS * support.tolerance)
    table = points[np.abs(height) < noise, :2]
    if not len(table):
        return 0.0
    first, last = table.min(axis=0), table.max(axis=0)
    above = (height >= noise) & (height < MAX_HEIGHT)
    above &= ~tray.encloses(points, WALL_MARGIN, content=True)
    for container in scene.containers:
        above &= ~container.on_walls(points, WALL_MARGIN)
    above &= ((points[:, :2] >= first) & (points[:, :2] <= last)).all(axis=1)
    # Cells overlap by half, so that no cell border splits a small object.
    half = 0.5 * GRID_CELL
    cells = ((points[above, :2] - first) / half).astype(np.intp)
    lens = frame.intrinsics
    areas = frame.depth[free][above].astype(np.float64) ** 2 / (lens.fx * lens.fy)
    sums = np.zeros(((last - first) / half).astype(np.intp) + 2)
    np.add.at(sums, tuple(cells.T), areas)
    rows = sums[1:] + sums[:-1]
    return float((rows[:, 1:] + rows[:, :-1]).max())
