"""Draw a gripper that was read from a file: open and closed, with its boxes and tool frame."""

from __future__ import annotations

from typing import TYPE_CHECKING

import cv2
import numpy as np

from .jaw_shapes import CORNERS
from .painted_view import PaintedView

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from eyehand.grasping.hands import DescribedHand

PANEL = (520, 640)
"""Height and width of each of four views, px."""
FRONT = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])
"""Axes of the view along y: x to the right, the approach downwards."""
PAPER, INK = (246, 247, 249), (34, 38, 43)
BODY, FINGER, PALM, CAMERA = (178, 184, 194), (0, 130, 95), (86, 120, 190), (213, 94, 0)
"""Colours of the gripper, and of the edges of boxes around fingers, palm and camera."""
AXES = ((200, 30, 30), (20, 140, 20), (30, 60, 210))
"""Colours of the axes x, y and z of the tool frame."""
AXIS_SHARE = 0.14
"""Length of a drawn axis as a share of the gripper's size."""
MARGIN = 1.12
FONT = cv2.FONT_HERSHEY_DUPLEX


def hand_picture(found: DescribedHand) -> NDArray[np.uint8]:
    """Draw the open and the closed gripper from the front and obliquely, (H, W, 3) uint8 RGB."""
    hand = found.hand
    points = np.concatenate([found.opened, found.closed]).reshape(-1, 3)
    low, high = points.min(axis=0), points.max(axis=0)
    rows = []
    for title, axes in (("from the front", FRONT), ("obliquely", _oblique())):
        row = []
        for word, triangles, opening in (
            ("open", found.opened, hand.stroke),
            ("closed", found.closed, hand.min_opening),
        ):
            corners = low + CORNERS * (high - low)
            flat = corners @ axes.T
            half = 0.5 * MARGIN * max(np.ptp(flat[:, 0]), np.ptp(flat[:, 1]) * PANEL[1] / PANEL[0])
            view = PaintedView(axes, 0.5 * (low + high), float(half), PANEL)
            _draw(view, found, triangles, opening, float(np.max(high - low)))
            picture = view.painted(PAPER)
            text = f"{hand.name} {word}, {1e3 * opening:.1f} mm, {title}"
            cv2.putText(picture, text, (12, 26), FONT, 0.6, INK, 1, cv2.LINE_AA)
            row.append(picture)
        rows.append(np.hstack(row))
    legend = np.full((40, rows[0].shape[1], 3), 255, np.uint8)
    x = 12
    for text, colour in (
        ("boxes of the fingers", FINGER),
        ("palm and linkage", PALM),
        ("camera", CAMERA),
        ("x: closing", AXES[0]),
        ("y", AXES[1]),
        ("z: approach", AXES[2]),
    ):
        cv2.putText(legend, text, (x, 26), FONT, 0.55, colour, 1, cv2.LINE_AA)
        x += cv2.getTextSize(text, FONT, 0.55, 1)[0][0] + 36
    return np.vstack([*rows, legend])


def _oblique() -> NDArray[np.float64]:
    """Return the axes of an oblique view with the approach downwards."""
    towards = np.array([0.55, 0.7, -0.45])
    towards /= np.linalg.norm(towards)
    right = np.cross([0.0, 0.0, -1.0], towards)
    right /= np.linalg.norm(right)
    return np.array([right, np.cross(towards, right), towards])


def _draw(
    view: PaintedView,
    found: DescribedHand,
    triangles: NDArray[np.float64],
    opening: float,
    size: float,
) -> None:
    hand = found.hand
    # Files wind triangles either way. Both sides are drawn.
    vertices = np.concatenate([triangles, triangles[:, ::-1]])
    view.add_mesh(vertices.reshape(-1, 3), np.arange(3 * len(vertices)).reshape(-1, 3), BODY)
    lift = 2.0 * size * view.axes[2]
    for boxes, colour in (
        (hand.jaw_boxes(opening), FINGER),
        (np.array([[box.low, box.high] for box in hand.palm_boxes]).reshape(-1, 2, 3), PALM),
        (np.array([[box.low, box.high] for box in hand.camera_boxes]).reshape(-1, 2, 3), CAMERA),
    ):
        for low, high in boxes:
            # Moved towards the viewer, so that the shapes do not hide the edges.
            view.add_wire(low + CORNERS * (high - low) + lift, colour, 1)
    for axis, colour in enumerate(AXES):
        end = np.zeros(3)
        end[axis] = AXIS_SHARE * size
        view.add_line(np.array([[0.0, 0.0, 0.0], end]) + 1.5 * lift, colour, 3)
