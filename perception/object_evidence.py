"""What a frame shows of one object: points, the plane below it, and the space around it."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import cv2
import numpy as np

from .segmentation.median import median
from .superquadric import MIN_POINTS, FitOptions, FreeSpace, SuperquadricFit, fit_superquadric
from .visibility import view_free_space

if TYPE_CHECKING:
    from numpy.typing import NDArray
    from scipy.spatial.transform import RigidTransform

    from .frame import DepthFrame
    from .segmentation import Segmentation

SPACING = 0.003
"""Maximum distance of the readings of an object across the line of sight, m. A fingertip that is
sunk in the object holds ten of them or more."""
MAX_READINGS = 10_000
"""Maximum number of readings at this distance, per object."""
BORDER_PX = 1
"""Pixels removed from the border of every segment before its fit. Depth is least reliable there:
some pixels mix the object with what lies behind it. Two pixels would lose thin objects."""


# Arrays have no truth value: equality is identity.
@dataclass(frozen=True, eq=False)
class RegionEvidence:
    """The evidence for one object in a frame, in the scene's frame: the input of its fit."""

    points: NDArray[np.float64]
    """Visible surface points, (N, 3), m."""
    view_origin: NDArray[np.float64]
    """Position of the camera, (3,), m."""
    support_plane: NDArray[np.float64] | None
    """Unit normal and offset (4,) of the plane that the object stands on, if it is known."""
    free_space: FreeSpace
    """Empty space around the object."""
    margin: float
    """Distance of the object's outline beyond that of the points, m."""

    def fit(self, options: FitOptions) -> SuperquadricFit:
        """Fit a solid."""
        margin = options.silhouette_margin + self.margin
        return fit_superquadric(
            self.points,
            view_origin=self.view_origin,
            support_plane=self.support_plane,
            free_space=self.free_space,
            options=replace(options, silhouette_margin=margin),
        )


def collect_evidence(
    cloud: NDArray[np.float64],
    plane: NDArray[np.float64] | None,
    frame: DepthFrame,
    T_scene_camera: RigidTransform,
    mask: NDArray[np.bool_],
) -> RegionEvidence:
    """Return what a frame shows of the object with a mask (H, W) and a cloud (N, 3)."""
    origin = np.asarray(T_scene_camera.translation)
    distance = median_distance(cloud, origin)
    return RegionEvidence(
        points=cloud,
        view_origin=origin,
        support_plane=plane,
        free_space=view_free_space(mask, frame, T_scene_camera),
        # The outline of the cloud is smaller than that of the object, by the removed border and
        # half a pixel on each side.
        margin=(BORDER_PX + 0.5) * distance / frame.intrinsics.fx,
    )


def median_distance(cloud: NDArray[np.float64], origin: NDArray[np.float64]) -> float:
    """Return the distance of the median of points (N, 3) from a place (3,), m; 0 without points."""
    if not len(cloud):
        return 0.0
    return float(np.linalg.norm([median(values) for values in cloud.T] - origin))


def sample_points(
    frame: DepthFrame,
    segmentation: Segmentation,
    label: int,
    box: tuple[slice, slice],
    count: int,
    rng: np.random.Generator,
) -> NDArray[np.float64]:
    """Sample points of a segment, camera frame: at most `count` at random, then those of a grid.

    The segment's border is left out if at least ``MIN_POINTS`` pixels remain. The grid has the
    points of large objects only, in which the first `count` are farther apart than ``SPACING``.
    """
    mask = segmentation.labels[box] == label
    side = 2 * BORDER_PX + 1
    eroded = cv2.erode(
        mask.astype(np.uint8),
        np.ones((side, side), np.uint8),
        borderType=cv2.BORDER_CONSTANT,
        borderValue=0,
    )
    if np.count_nonzero(eroded) >= MIN_POINTS:
        mask = eroded > 0
    rows, columns = np.nonzero(mask & (frame.depth[box] > 0))
    k = frame.intrinsics
    if rows.size > count:
        drawn = np.sort(rng.choice(rows.size, count, replace=False))
        step = SPACING * k.fx / float(np.median(frame.depth[box][rows[drawn], columns[drawn]]))
        step = max(int(step), 1, math.ceil(math.sqrt(rows.size / MAX_READINGS)))
        on_grid = (rows % step == 0) & (columns % step == 0)
        if np.count_nonzero(on_grid) > count:
            on_grid[drawn] = False
            drawn = np.append(drawn, np.flatnonzero(on_grid))
        rows, columns = rows[drawn], columns[drawn]
    rows, columns = rows + box[0].start, columns + box[1].start
    z = frame.depth[rows, columns].astype(np.float64)
    return np.column_stack([(columns - k.cx) / k.fx * z, (rows - k.cy) / k.fy * z, z])
