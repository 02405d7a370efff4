"""Why a grasp of the clutter-removal protocol failed, by the simulation's ground truth."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from eyehand.data_synth.cell import ClutterWorld, Execution
    from eyehand.grasping import Grasp
    from eyehand.perception import Scene

FALSE_SHARE = 0.5
"""A segment with a larger share of background pixels is no object."""
MERGED_SHARE = 0.2
"""A segment with a larger share of pixels of a second object holds two."""
WRONG_WIDTH = 0.010
"""Error of width or of the middle from which the solid is wrong, m."""
HEAVY_SHARE = 0.4
"""Weight over the friction of both pads from which an object is heavy. On development objects, 10
of 11 grasps of heavier objects slipped, and few of lighter ones."""
SURFACE_POINTS = 4000
"""Number of points on the true surface."""
GRAVITY = 9.81


@dataclass(frozen=True)
class SegmentTruth:
    """The true objects in the segment of a grasp."""

    index: int
    """Index of the true object, or -1 for background."""
    name: str
    """Its name."""
    mass: float
    """Its mass, kg."""
    background: float
    """Share of background pixels."""
    second: float
    """Share of pixels of a second object."""
    width_error: float
    """Planned minus true width between the pads, m; NaN if the true object is not there."""
    offset: float
    """Distance of the true middle from the middle of the hand along the closing axis, m."""


def segment_truth(
    scene: Scene, grasp: Grasp, labels: NDArray[np.int32], world: ClutterWorld
) -> SegmentTruth:
    """Compare the segment and the width of a grasp with the simulation.

    Parameters
    ----------
    scene
        The perceived scene.
    grasp
        The grasp.
    labels
        True object of each pixel, 0 for background, k for object k-1, (H, W).
    world
        The world before the grasp.
    """
    shown = labels[scene.segmentation.mask(grasp.object_label)]
    counts = np.bincount(shown, minlength=len(world.objects) + 1)
    share = counts / max(counts.sum(), 1)
    order = np.argsort(-share[1:])
    index, second = int(order[0]), float(share[1:][order[1]]) if len(order) > 1 else 0.0
    if share[0] > FALSE_SHARE:
        return SegmentTruth(-1, "background", 0.0, float(share[0]), second, np.nan, np.nan)
    local = grasp.T_scene_tcp.inv().apply(_surface(world, index))
    pad = world.hand
    inside = (np.abs(local[:, 1]) < 0.5 * pad.pad_width) & (local[:, 2] <= 0.0)
    inside &= local[:, 2] >= -pad.pad_height
    x = local[inside, 0]
    width = grasp.object_width - np.ptp(x) if len(x) else np.nan
    offset = 0.5 * abs(x.min() + x.max()) if len(x) else np.nan
    item = world.objects[index]
    return SegmentTruth(
        index, item.name, item.mass, float(share[0]), second, float(width), float(offset)
    )


def failure_cause(course: Execution, truth: SegmentTruth, grasp: Grasp, force: float) -> str:
    """Return the cause of a failed grasp, one of `CAUSES`."""
    if truth.index < 0:
        return "false object"
    if truth.second > MERGED_SHARE:
        return "merged segment"
    if is_heavy(truth.mass, force):
        return "too heavy"
    if course.at_start:
        return "collision at the start"
    if not abs(truth.width_error) < WRONG_WIDTH or not truth.offset < WRONG_WIDTH:
        return "wrong solid"
    if course.stopped_by is not None and course.stopped_before > 0.0:
        if course.stopped_by == truth.index:
            return "stopped by the object"
        return "stopped by the table" if course.stopped_by < 0 else "stopped by another object"
    return "slipped" if course.touched_any else "missed"


def is_heavy(mass: float, force: float) -> bool:
    """Return whether an object weighs more than the hand can be expected to hold."""
    return mass * GRAVITY > HEAVY_SHARE * 2.0 * force


def _surface(world: ClutterWorld, index: int) -> NDArray[np.float64]:
    """Return points on the true surface of an object in the world, (N, 3), m."""
    item = world.objects[index]
    corners = item.vertices[item.faces]
    edges = corners[:, 1:] - corners[:, :1]
    area = np.linalg.norm(np.cross(edges[:, 0], edges[:, 1]), axis=1)
    rng = np.random.default_rng(0)
    face = rng.choice(len(area), SURFACE_POINTS, p=area / area.sum())
    u, v = np.sort(rng.random((2, SURFACE_POINTS)), axis=0)
    points = (
        corners[face, 0] * u[:, None]
        + corners[face, 1] * (v - u)[:, None]
        + corners[face, 2] * (1.0 - v)[:, None]
    )
    return world.pose(index).apply(points)
