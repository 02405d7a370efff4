"""Geometry of the grasps of an object: directions, sizes, and the freedom from its symmetry."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Literal

import numpy as np

from .fit_uncertainty import width_stds

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from eyehand.perception import SceneObject, Superquadric, SuperquadricFit, SupportPlane

    from .extents import Extents
    from .prototypes import Approach

Freedom = Literal["any_tilt", "turn", "around", "none"]
"""Motion of the hand that the object's symmetry leaves free.

- any_tilt: the approach may tilt towards a sphere's centre, up to
  ``PalmPlacement.max_approach_angle``, and the hand may turn about the palm's direction.
- turn: the hand may turn about the palm's direction.
- around: the approach may turn about a vertical axis.
- none: no freedom.
"""

PARALLEL_COSINE = 0.94
"""Cosine of the maximum angle between two directions that count as parallel (20°)."""


# Equality is identity, because arrays have no truth value.
@dataclass(frozen=True, eq=False)
class GraspGeometry:
    """Directions and sizes of one grasp, in the scene's frame."""

    kind: str
    """Kind of the fitted solid."""
    approach: Approach
    """Whether the palm comes from the side or from the top."""
    freedom: Freedom
    """Motion of the hand that the object's symmetry leaves free."""
    closing: NDArray[np.float64]
    """Unit direction (3,) from the fingers to the thumb. If the hand may turn freely, it is one of
    many."""
    palm: NDArray[np.float64]
    """Unit direction (3,) that the palm faces. If the approach is free, it is one of many."""
    finger_row: NDArray[np.float64]
    """Unit direction (3,) of the row of fingers."""
    up: NDArray[np.float64]
    """Unit up direction (3,)."""
    centre: NDArray[np.float64]
    """Centre of the object's bounding box along the grasp directions, (3,), m."""
    width: float
    """Object extent along the closing direction, m."""
    length: float
    """Object extent along the row of fingers, m."""
    height: float
    """Object extent along up, m."""
    half_depth: float
    """Distance between the centre and the object's near face along the palm's direction, m."""
    rise: float
    """Height of the centre above the surface that the object rests on, m."""
    width_std: float
    """Standard deviation of the width, m. Most of it comes from unseen sides."""
    flat_face: bool = False
    """Whether the object's face in front of the palm is flat over the object's whole width."""
    max_approach_angle: float = float(np.pi)
    """Maximum angle between the approach and ``palm``, rad. Neighbours may limit it more than the
    symmetry of the object."""


def grasp_geometries(
    item: SceneObject, solid: Superquadric, extents: Extents, support: SupportPlane | None
) -> tuple[GraspGeometry, ...]:
    """Return all different grasp geometries of an object, with the thumb on either side.

    Parameters
    ----------
    item
        The object; its fit holds the uncertainty.
    solid, extents
        The solid to be grasped, which may differ from that of the fit, and its extents.
    support
        Support plane. Without one, or on top of another object, the object's lowest point defines
        the ground.
    """
    up, narrow = extents.up, extents.closing
    across = np.cross(up, narrow)
    ground = _ground_height(item, solid, support, up)
    grasps: list[tuple[Approach, Freedom, NDArray[np.float64], NDArray[np.float64]]] = []
    if extents.round:
        grasps.append(("top", "any_tilt" if solid.kind == "sphere" else "turn", narrow, -up))
        for thumb in (narrow, -narrow):
            grasps.append(("side", "around", thumb, across))
    else:
        for closing, along in ((narrow, across), (across, narrow)):
            for thumb in (closing, -closing):
                grasps.append(("top", "none", thumb, -up))
                grasps.append(("side", "none", thumb, along))
                grasps.append(("side", "none", thumb, -along))
    measured = _MeasuredSolid(item.fit, solid, np.array([narrow, across, up]))
    return tuple(_geometry(measured, ground, *grasp) for grasp in grasps)


def turned(geometry: GraspGeometry, count: int) -> tuple[GraspGeometry, ...]:
    """Return ``count`` copies, rotated about ``up`` in equal steps of a full turn, original first.

    The widths are not changed, so they must be the same in all horizontal directions.
    """
    horizontal = _horizontal_direction(geometry)
    side = np.cross(geometry.up, horizontal)
    angles = np.arange(count)[:, None] * 2.0 * np.pi / count
    turns = np.cos(angles) * horizontal + np.sin(angles) * side
    if geometry.approach == "top":
        rows = np.cross(geometry.palm, turns)
        return tuple(
            replace(geometry, closing=turn, finger_row=row)
            for turn, row in zip(turns, rows, strict=True)
        )
    closings = np.cross(geometry.finger_row, turns)
    closings /= np.linalg.norm(closings, axis=1, keepdims=True)
    return tuple(
        replace(geometry, palm=turn, closing=closing)
        for turn, closing in zip(turns, closings, strict=True)
    )


def _horizontal_direction(geometry: GraspGeometry) -> NDArray[np.float64]:
    """Return the horizontal direction of a grasp: closing in a top grasp, palm in a side grasp."""
    return geometry.closing if geometry.approach == "top" else geometry.palm


class _MeasuredSolid:
    """Extents and uncertainties of a solid along three orthogonal axes, computed once."""

    def __init__(
        self, fit: SuperquadricFit, solid: Superquadric, axes: NDArray[np.float64]
    ) -> None:
        ends = solid.support(np.vstack([axes, -axes]))
        self.kind, self.own_axis = solid.kind, solid.rotation[:, 2]
        self.axes, self.up = axes, axes[2]
        self.widths = ends[:3] + ends[3:]
        self.centre = 0.5 * (ends[:3] - ends[3:]) @ axes
        self.width_stds = width_stds(fit, np.asarray(axes))

    def axis_index(self, direction: NDArray[np.float64]) -> int:
        """Return the index of the axis that is parallel to a direction (3,)."""
        return int(np.argmax(np.abs(self.axes @ direction)))


def _geometry(
    solid: _MeasuredSolid,
    ground: float,
    approach: Approach,
    freedom: Freedom,
    closing: NDArray[np.float64],
    palm: NDArray[np.float64],
) -> GraspGeometry:
    finger_row = np.cross(palm, closing)
    row_index = solid.axis_index(finger_row)
    if freedom == "around" and solid.kind != "sphere":
        cosine = float(solid.own_axis @ finger_row)
        if abs(cosine) > PARALLEL_COSINE:
            finger_row = solid.own_axis * np.sign(cosine)
    return GraspGeometry(
        kind=solid.kind,
        approach=approach,
        freedom=freedom,
        closing=closing,
        palm=palm,
        finger_row=finger_row,
        up=solid.up,
        centre=solid.centre,
        width=float(solid.widths[solid.axis_index(closing)]),
        length=float(solid.widths[row_index]),
        height=float(solid.widths[2]),
        half_depth=0.5 * float(solid.widths[solid.axis_index(palm)]),
        rise=float(solid.centre @ solid.up) - ground,
        width_std=solid.width_stds[solid.axis_index(closing)],
        flat_face=_has_flat_face(solid, palm),
    )


def _has_flat_face(solid: _MeasuredSolid, palm: NDArray[np.float64]) -> bool:
    if solid.kind == "cylinder":
        return abs(float(solid.own_axis @ palm)) > PARALLEL_COSINE
    return solid.kind in ("box", "superquadric")


def _ground_height(
    item: SceneObject,
    solid: Superquadric,
    support: SupportPlane | None,
    up: NDArray[np.float64],
) -> float:
    """Return the coordinate along up of the surface that the object rests on, m."""
    lowest = -float(solid.support(-up))
    if support is None or item.rests_on not in (0, None):
        return lowest
    return -support.offset
