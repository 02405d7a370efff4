"""Grasp variants that need less free space: turned, shallower, or off the middle."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from .palm_placement import TipDepth

if TYPE_CHECKING:
    from collections.abc import Iterator

    from numpy.typing import NDArray

    from eyehand.perception import Superquadric

    from .grasp_geometry import GraspGeometry

DIRECTIONS = 8
"""Number of closing directions over half a turn, tried on solids without flat sides."""
MAX_WIDTH_RATIO = 1.25
"""Maximum ratio of the width along such a direction to the smallest width. In other directions the
fingers turn the object before they hold it."""
OFFSET_SHARE = 0.22
"""Offset of the grasp from the middle of a long object, as a share of its length."""
MIN_LONG = 0.050
"""Length above which an object is also grasped off its middle, m."""
STRAIGHT_KINDS = ("box", "cylinder", "superquadric", "tapered")
"""Kinds that have about the same width off their middle."""
SHALLOW_BELOW_FACE = 0.013
"""Depth of the fingertips below a flat top in a shallow grasp, m."""
SHALLOW_BEYOND_CENTRE = 0.003
"""Depth of the fingertips beyond the centre of a round object in a shallow grasp, m."""


def low_clearance_grasps(
    geometry: GraspGeometry, solid: Superquadric, narrowest: float
) -> Iterator[tuple[GraspGeometry, TipDepth, float]]:
    """Yield variants of a top grasp, each with its fingertip depth and weight in [0, 1].

    The weight decreases off the middle, with shallow grasps and with the width. All variants have
    a fixed orientation.

    Parameters
    ----------
    geometry
        A top grasp.
    solid
        Solid to grasp.
    narrowest
        Smallest horizontal width of the solid, m.
    """
    for variant, weight in _variants(geometry, solid, narrowest):
        yield variant, TipDepth(), weight
        yield variant, _shallow_depth(variant), 0.8 * weight


def _variants(
    geometry: GraspGeometry, solid: Superquadric, narrowest: float
) -> Iterator[tuple[GraspGeometry, float]]:
    for closing in _closing_directions(geometry, solid):
        turned = _turned(geometry, solid, closing)
        if turned.width > MAX_WIDTH_RATIO * max(narrowest, geometry.width):
            continue
        weight = float(min(geometry.width / turned.width, 1.0)) ** 2
        yield turned, weight
        is_long = turned.length > MIN_LONG and turned.width < turned.length
        if geometry.kind in STRAIGHT_KINDS and is_long:
            for share in (-OFFSET_SHARE, OFFSET_SHARE):
                centre = turned.centre + share * turned.length * turned.finger_row
                yield replace(turned, centre=centre), 0.7 * weight


def _closing_directions(geometry: GraspGeometry, solid: Superquadric) -> list[NDArray[np.float64]]:
    if solid.kind in ("box", "cylinder") and geometry.freedom == "none":
        return [geometry.closing]
    across = np.cross(geometry.up, geometry.closing)
    if geometry.freedom == "none":
        # The other pair of sides has its own grasp, so half of the angle to it is enough.
        angles = np.arange(-DIRECTIONS // 4 + 1, DIRECTIONS // 4 + 1) * np.pi / DIRECTIONS
    else:
        angles = np.arange(2 * DIRECTIONS) * np.pi / DIRECTIONS
    return [np.cos(angle) * geometry.closing + np.sin(angle) * across for angle in angles]


def _turned(
    geometry: GraspGeometry, solid: Superquadric, closing: NDArray[np.float64]
) -> GraspGeometry:
    finger_row = np.cross(geometry.palm, closing)
    axes = np.array([closing, finger_row])
    widths = solid.support(axes) + solid.support(-axes)
    return replace(
        geometry,
        freedom="none",
        closing=closing,
        finger_row=finger_row,
        width=float(widths[0]),
        length=float(widths[1]),
    )


def _shallow_depth(geometry: GraspGeometry) -> TipDepth:
    # A superquadric may be round below a face that looks flat.
    if geometry.flat_face and geometry.kind != "superquadric":
        return TipDepth(SHALLOW_BELOW_FACE, -float("inf"))
    return TipDepth(0.0, SHALLOW_BEYOND_CENTRE)
