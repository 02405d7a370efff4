"""Boxes around fingers, palm, linkage and camera of a gripper, in its tool frame."""

from __future__ import annotations

import re
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .jaw_motion import JawMotion
from .pad_area import between_jaws
from .shapes import beyond_plane, clipped, slab_boxes

Boxes = list[tuple[NDArray[np.float64], NDArray[np.float64]]]


CAMERA_NAMES = re.compile(
    r"cam(era)?(_|\d|$)|realsense|d4[0-9]{2}|d405|zed|kinect|oak", re.IGNORECASE
)
"""Names of bodies, geoms and meshes that are a camera or its mount."""
POSTURE_STRIDE = 2
"""Every second posture is enclosed."""
ROW = 4e-3
"""Height of the rows in which a linkage is compared, m."""
SAME_POSE = 1e-4
"""Difference of the pads' motion from a straight line along x that counts as none, m."""


def tool_origin(motion: JawMotion, middle_y: float) -> NDArray[np.float64]:
    """Return the origin of the tool frame in the axes of a motion, (3,), m.

    x is that of the closed jaws, y the middle of the pads, and z the farthest fingertip.
    """
    return np.array([motion.faces[-1].mean(), middle_y, float(motion.tips.max())])


def finger_boxes(motion: JawMotion, origin: NDArray[np.float64]) -> Boxes:
    """Return boxes around both fingers, as the finger at +x with its pad at x = 0."""
    clouds = [linkage.with_pad for linkage in _linkages(motion, origin)]
    for posture in _postures(motion):
        motion.posed(posture)
        for side, links in enumerate(motion.pads):
            triangles = motion.of_links(links)
            clouds.append(_as_right_finger(motion, triangles, side, posture, origin))
    if len(motion.pads) == 1:
        clouds.append(_as_right_finger(motion, _fixed_jaw(motion), 1, 0, origin))
    return slab_boxes(clouds)


def palm_boxes(motion: JawMotion, origin: NDArray[np.float64]) -> Boxes:
    """Return boxes around the palm, and around the linkage behind the fingers in all postures."""
    boxes: Boxes = []
    camera = set(_camera_geoms(motion))
    fixed = [geom for geom in motion.shapes.fixed_geoms if geom not in camera]
    front = _fixed_jaw_base(motion) - origin[2] if len(motion.pads) == 1 else np.inf
    motion.posed(0)
    palm = motion.shapes.triangles(fixed) @ motion.axes - origin
    # A fixed jaw is one of the fingers.
    boxes += slab_boxes([palm], high=front)
    for linkage in _linkages(motion, origin):
        boxes += slab_boxes([linkage.with_palm])
    return _swept(motion, boxes)


def _swept(motion: JawMotion, boxes: Boxes) -> Boxes:
    """Widen boxes of the palm by the way of the tool frame along x while the jaws close."""
    middles = motion.faces.mean(axis=1)
    shifts = middles[-1] - middles
    back, forth = np.array([shifts.min(), 0.0, 0.0]), np.array([shifts.max(), 0.0, 0.0])
    return [(low + back, high + forth) for low, high in boxes]


@dataclass(frozen=True, eq=False)
class _Linkage:
    """The links of a side that carry no pad, in all postures, cut at a height."""

    with_pad: NDArray[np.float64]
    """Triangles in front of the cut, in the frame of the finger at +x, (T, 3, 3), m."""
    with_palm: NDArray[np.float64]
    """Triangles behind the cut in the tool frame, (T, 3, 3), m."""


def _linkages(motion: JawMotion, origin: NDArray[np.float64]) -> list[_Linkage]:
    """Cut the linkage of each side where it moves less with the palm than with the pad."""
    found = []
    for side in range(len(motion.pads)):
        rest = [link for link in motion.jaws.sides[side] if link not in motion.pads[side]]
        if not rest:
            continue
        own, placed = [], []
        for posture in range(0, len(motion.path), POSTURE_STRIDE):
            motion.posed(posture)
            triangles = motion.of_links(rest)
            placed.append(triangles - origin)
            own.append(_as_right_finger(motion, triangles, side, posture, origin))
        beside, swept = np.concatenate(own), np.concatenate(placed)
        if not len(swept):
            continue
        rows = np.arange(swept[:, :, 2].min(), swept[:, :, 2].max(), ROW)
        sections = np.array([[_section(cloud, row) for cloud in (beside, swept)] for row in rows])
        # Rows from the cut on belong to the finger, those below to the palm.
        costs = [sections[:cut, 1].sum() + sections[cut:, 0].sum() for cut in range(len(rows) + 1)]
        cut = int(np.argmin(costs))
        height = float(rows[cut]) if cut < len(rows) else np.inf
        in_front = beyond_plane(beside, 2, 1.0, height) if cut < len(rows) else beside[:0]
        behind = beyond_plane(swept, 2, -1.0, -height)
        found.append(_Linkage(in_front, behind if cut else swept[:0]))
    return found


def _section(triangles: NDArray[np.float64], low: float) -> float:
    """Return the area of the box around a slab, m²."""
    points = clipped(triangles, 2, low, low + ROW)
    return float(np.prod(np.ptp(points[:, :2], axis=0))) if len(points) else 0.0


def camera_boxes(motion: JawMotion, origin: NDArray[np.float64]) -> Boxes:
    """Return boxes around a camera and its mount on the palm, found by their names."""
    motion.posed(0)
    cloud = motion.shapes.triangles(_camera_geoms(motion)) @ motion.axes - origin
    return _swept(motion, slab_boxes([cloud])) if len(cloud) else []


def _camera_geoms(motion: JawMotion) -> list[int]:
    model = motion.shapes.posing.model
    found = []
    for geom in motion.shapes.fixed_geoms:
        mesh = int(model.geom_dataid[geom])
        names = [model.geom(geom).name, model.body(int(model.geom_bodyid[geom])).name]
        if mesh >= 0:
            names.append(model.mesh(mesh).name)
        if any(CAMERA_NAMES.search(name) for name in names):
            found.append(geom)
    return found


def _postures(motion: JawMotion) -> list[int]:
    """Return the postures that differ in the frame of the pad: all, or one for a straight slide."""
    last = len(motion.path) - 1
    shapes = []
    for posture in (0, last // 2, last):
        motion.posed(posture)
        cloud = motion.of_links(motion.pads[0]).reshape(-1, 3)
        shapes.append(cloud - [motion.faces[posture, 0], 0.0, 0.0])
    if all(np.abs(shape - shapes[0]).max() < SAME_POSE for shape in shapes):
        return [0]
    return [*range(0, last, POSTURE_STRIDE), last]


def _as_right_finger(
    motion: JawMotion,
    triangles: NDArray[np.float64],
    side: int,
    posture: int,
    origin: NDArray[np.float64],
) -> NDArray[np.float64]:
    """Return triangles in the tool frame, mirrored to +x, with the pad's face at x = 0."""
    moved = triangles - [motion.faces[posture, side], origin[1], origin[2]]
    return moved * [motion.side_sign(side), 1.0, 1.0]


def _fixed_jaw(motion: JawMotion) -> NDArray[np.float64]:
    """Return the triangles of the palm in front of its base: the jaw that does not move."""
    base = _fixed_jaw_base(motion)
    motion.posed(0)
    palm = motion.fixed()
    kept = palm[palm[:, :, 2].max(axis=1) > base]
    return np.concatenate([kept[:, :, :2], np.maximum(kept[:, :, 2:], base)], axis=2)


def _fixed_jaw_base(motion: JawMotion) -> float:
    """Return the z at which the fixed jaw leaves the palm, m."""
    low, high, _ = motion.pad_extent(0, 0)
    front = between_jaws(motion, 0, low, high)
    return front if np.isfinite(front) else float(motion.tips[0]) - motion.length
