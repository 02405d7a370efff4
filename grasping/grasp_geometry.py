"""Geometry of the grasps of an object: directions, sizes, and what symmetry leaves free."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Literal

import numpy as np

from .fit_uncertainty import width_std

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from eyehand.perception import SceneObject, Superquadric, SuperquadricFit, SupportPlane

    from .extents import Extents
    from .prototypes import Approach

Freedom = Literal["any_side", "turn", "around", "none"]
"""Freedom that the object's symmetry leaves.

- any_side: any direction towards a sphere's centre.
- turn: the rotation about the palm's direction.
- around: the approach direction about a vertical axis.
- none: no freedom.
"""

UPRIGHT_COSINE = 0.94
"""Cosine of the maximum tilt of an axis that counts as vertical (20°)."""


# Equality is identity, because arrays have no truth value.
@dataclass(frozen=True, eq=False)
class GraspGeometry:
    """Directions and sizes of one grasp, in the scene's frame."""

    kind: str
    """Kind of the fitted solid."""
    approach: Approach
    """Whether the palm comes from the side or from the top."""
    freedom: Freedom
    """Freedom of the grasp."""
    closing: NDArray[np.float64]
    """Unit direction (3,) from the fingers to the thumb; an example where the turn is free."""
    palm: NDArray[np.float64]
    """Unit direction (3,) that the palm faces; an example where the approach is free."""
    axis: NDArray[np.float64]
    """Unit direction (3,) of the row of fingers."""
    up: NDArray[np.float64]
    """Unit up direction (3,)."""
    centre: NDArray[np.float64]
    """Centre of the object's extents along the grasp axes, (3,), m."""
    width: float
    """Object width along the closing direction, m."""
    length: float
    """Object width along the row of fingers, m."""
    height: float
    """Extent along up, m."""
    half_depth: float
    """Distance between the centre and the object's near face along the palm's direction, m."""
    rise: float
    """Height of the centre above the surface that the object rests on, m."""
    width_std: float
    """Standard deviation of the width, m; mostly from unseen sides."""
    flat: bool = False
    """Whether the face in front of the palm is about as wide as the object."""
    cone: float = float(np.pi)
    """Maximum angle of the approach from ``palm`` within the freedom, rad."""


def grasp_geometries(
    item: SceneObject, solid: Superquadric, extents: Extents, support: SupportPlane | None
) -> tuple[GraspGeometry, ...]:
    """Return all different grasp geometries, with the thumb on either side.

    Parameters
    ----------
    item
        The object; its fit holds the uncertainty.
    solid, extents
        Its solid, and the extents of it.
    support
        Support plane. Without one the object's lowest point defines the ground.
    """
    up, narrow = extents.up, extents.closing
    across = np.cross(up, narrow)
    ground = _ground_height(item, solid, support, up)
    grasps: list[tuple[Approach, Freedom, NDArray[np.float64], NDArray[np.float64]]] = []
    if extents.round:
        grasps.append(("top", "any_side" if solid.kind == "sphere" else "turn", narrow, -up))
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
    """Return ``count`` copies turned about up over a full turn, the original first.

    The object must be rotationally symmetric for the hand: widths are kept.
    """
    flat = _horizontal_direction(geometry)
    side = np.cross(geometry.up, flat)
    copies = []
    for angle in np.arange(count) * 2.0 * np.pi / count:
        turn = np.cos(angle) * flat + np.sin(angle) * side
        if geometry.approach == "top":
            copies.append(replace(geometry, closing=turn, axis=np.cross(geometry.palm, turn)))
        else:
            closing = np.cross(geometry.axis, turn)
            closing /= np.linalg.norm(closing)
            copies.append(replace(geometry, palm=turn, closing=closing))
    return tuple(copies)


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
        self.width_stds = [width_std(fit, axis) for axis in axes]

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
    axis = np.cross(palm, closing)
    along = solid.axis_index(axis)
    if freedom == "around" and solid.kind != "sphere":
        upright = float(solid.own_axis @ axis)
        if abs(upright) > UPRIGHT_COSINE:
            axis = solid.own_axis * np.sign(upright)
    return GraspGeometry(
        kind=solid.kind,
        approach=approach,
        freedom=freedom,
        closing=closing,
        palm=palm,
        axis=axis,
        up=solid.up,
        centre=solid.centre,
        width=float(solid.widths[solid.axis_index(closing)]),
        length=float(solid.widths[along]),
        height=float(solid.widths[2]),
        half_depth=0.5 * float(solid.widths[solid.axis_index(palm)]),
        rise=float(solid.centre @ solid.up) - ground,
        width_std=solid.width_stds[solid.axis_index(closing)],
        flat=_has_flat_face(solid, palm),
    )


def _has_flat_face(solid: _MeasuredSolid, palm: NDArray[np.float64]) -> bool:
    if solid.kind == "cylinder":
        return abs(float(solid.own_axis @ palm)) > UPRIGHT_COSINE
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
