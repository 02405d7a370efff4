"""Draw the best grasps of a gripper: in the image, in 3D, and as a list."""

from __future__ import annotations

from typing import TYPE_CHECKING

import cv2
import numpy as np

from eyehand.perception.superquadric import mesh

from ..console import counted
from ..scene_json import fit_parts
from ..scene_picture import SUBPIXEL, colour_of, overlay_picture
from .jaw_shapes import EDGES, FACES, DrawnGrasp, drawn_grasps
from .painted_view import PaintedView
from .view_scene import AROUND, nearby_points, view_axes, viewed_points

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from .jaw_frame import GraspedFrame

PANEL_HEIGHT = 720
PANEL_WIDTH = 880
"""Size of the 3D view, px."""
IMAGE_WIDTH = 960
"""Width of the image beside it, px, where the frame is wide enough."""
CROP_MARGIN = 0.12
"""Margin around objects and grippers in the image, as a share of their extent."""
MIN_CROP = 0.35
"""Minimum width of the shown part of the image, as a share of the whole."""
FORBIDDEN = (215, 0, 40)
"""Colour of the ring around the rank of a grasp that must not be executed, RGB."""
PAPER, INK, FAINT, DARK = (246, 247, 249), (34, 38, 43), (107, 114, 128), (20, 20, 20)
FILL = 0.5
"""Opacity of the fingers in the image."""
LINE, LINE_HEIGHT, FONT = 2, 30, cv2.FONT_HERSHEY_DUPLEX
MAX_NOTES = 6
"""Maximum number of objects without a grasp that the list names."""
RESOLUTION = 40
"""Points around a drawn solid."""


def grasps_picture(found: GraspedFrame) -> NDArray[np.uint8]:
    """Draw the best grasp of each object, (H, W, 3) uint8 RGB.

    A gripper has the colour of its object. The palm is drawn for the best grasp only.
    """
    drawn = drawn_grasps(found)
    image = _image_panel(found, drawn)
    view = _view_panel(found, drawn)
    row = np.hstack([image, np.full((PANEL_HEIGHT, 10, 3), 255, np.uint8), view])
    return np.vstack([row, _list_panel(found, drawn, row.shape[1])])


def _image_panel(found: GraspedFrame, drawn: list[DrawnGrasp]) -> NDArray[np.uint8]:
    """Draw the grippers over the segments and the outlines of the solids."""
    picture = overlay_picture(found.frame, found.scene, {}, names=False)
    zoom = picture.shape[1] / found.frame.depth.shape[1]
    pose = found.scene_in_camera

    def pixels(points: NDArray[np.float64]) -> NDArray[np.int32] | None:
        flat = found.frame.intrinsics.project(pose.apply(points.reshape(-1, 3)))
        if not np.isfinite(flat).all():
            return None
        flat = np.clip((flat + 0.5) * zoom - 0.5, -1e4, 1e4) * (1 << SUBPIXEL)
        return np.round(flat).astype(np.int32).reshape(*points.shape[:-1], 2)

    for one in reversed(drawn):
        boxes = pixels(one.fingers)
        if boxes is not None:
            layer = picture.copy()
            for box in boxes:
                for face in FACES:
                    cv2.fillConvexPoly(layer, box[list(face)], one.colour, cv2.LINE_AA, SUBPIXEL)
            cv2.addWeighted(layer, FILL, picture, 1.0 - FILL, 0.0, dst=picture)
            for box in boxes:
                _draw_edges(picture, box, one.colour, 1)
        lines = [pixels(one.fork), pixels(one.stem)]
        for thick, colour in ((LINE + 4, DARK), (LINE + 1, one.colour)):
            for line in lines:
                if line is not None:
                    cv2.polylines(picture, [line], False, colour, thick, cv2.LINE_AA, SUBPIXEL)
        palm = pixels(one.palm)
        if one is drawn[0] and palm is not None:
            for box in palm:
                _draw_edges(picture, box, one.colour, 1)
    for one in reversed(drawn):
        end = pixels(one.stem)
        if end is not None:
            x, y = (end[0] >> SUBPIXEL).tolist()
            _tag(picture, (x, y), one, scale=picture.shape[1] / 1280)
    marked = [pixels(np.concatenate([one.fork, one.stem])) for one in drawn]
    return _cropped(picture, found, [line / (1 << SUBPIXEL) for line in marked if line is not None])


def _cropped(
    picture: NDArray[np.uint8], found: GraspedFrame, marked: list[NDArray[np.float64]]
) -> NDArray[np.uint8]:
    """Return the part of the picture with objects and grippers, in the size of the panel."""
    height, width = picture.shape[:2]
    zoom = width / found.frame.depth.shape[1]
    rows, columns = np.nonzero(found.scene.segmentation.labels)
    everything = [np.column_stack([columns, rows]) * zoom, *marked]
    places = np.concatenate([part for part in everything if len(part)] or [np.zeros((1, 2))])
    if len(places) > 1:
        low, high = places.min(axis=0), places.max(axis=0)
        size = (high - low) * (1 + 2 * CROP_MARGIN)
        side = min(max(size[0], size[1] * IMAGE_WIDTH / PANEL_HEIGHT, MIN_CROP * width), width)
        tall = min(side * PANEL_HEIGHT / IMAGE_WIDTH, height)
        left, top = np.clip(0.5 * (low + high) - 0.5 * np.array([side, tall]), 0, None)
        left, top = min(int(left), int(width - side)), min(int(top), int(height - tall))
        picture = picture[top : top + int(tall), left : left + int(side)]
    panel_width = round(picture.shape[1] * PANEL_HEIGHT / picture.shape[0])
    how = cv2.INTER_AREA if picture.shape[0] > PANEL_HEIGHT else cv2.INTER_CUBIC
    return np.asarray(cv2.resize(picture, (panel_width, PANEL_HEIGHT), interpolation=how), np.uint8)


def _view_panel(found: GraspedFrame, drawn: list[DrawnGrasp]) -> NDArray[np.uint8]:
    """Draw points, solids and grippers in 3D."""
    scene = found.scene
    axes = view_axes(found)
    shown = viewed_points(found)
    if not len(shown):
        shown, _ = nearby_points(found)
    flat = shown @ axes.T
    low, high = np.percentile(flat, [0.5, 99.5], axis=0)
    if drawn:
        boxes = [drawn[0].palm, *(one.fingers for one in drawn)]
        tips = np.concatenate([box.reshape(-1, 3) for box in boxes]) @ axes.T
        low, high = np.minimum(low, tips.min(axis=0)), np.maximum(high, tips.max(axis=0))
    aspect = PANEL_WIDTH / PANEL_HEIGHT
    half = 0.5 * max(high[0] - low[0], aspect * (high[1] - low[1])) + AROUND / 2
    middle = 0.5 * (low + high) @ axes
    view = PaintedView(axes, middle, float(half), (PANEL_HEIGHT, PANEL_WIDTH))
    points, colours = nearby_points(found)
    view.add_points(points, colours)
    for item in scene.objects:
        shade = np.round(0.45 * colour_of(item.label) + 0.55 * 255).astype(int).tolist()
        for solid in fit_parts(item.fit) if item.fit else ():
            view.add_mesh(*mesh(solid, RESOLUTION), (shade[0], shade[1], shade[2]))
    for one in drawn:
        for box in one.fingers:
            view.add_box(box, one.colour)
        view.add_line(one.fork[1:3], one.colour, 2)
        view.add_line(one.stem, one.colour, 2)
    for box in drawn[0].palm if drawn else ():
        view.add_wire(box, drawn[0].colour, 1)
    picture = view.painted(PAPER)
    for one in reversed(drawn):
        _tag(picture, view.pixel_of(one.stem[0]), one, scale=0.8)
    return picture


def _list_panel(found: GraspedFrame, drawn: list[DrawnGrasp], width: int) -> NDArray[np.uint8]:
    """Write one line for each drawn grasp."""
    notes = [
        (f"object {item.label}: no grasp: {found.why_none(item.label)}", colour_of(item.label))
        for item in found.scene.objects
        if item.label not in found.best_ranks
    ][:MAX_NOTES]
    if len(found.best_ranks) > len(drawn):
        more = len(found.best_ranks) - len(drawn)
        notes.insert(0, (f"{more} more with a grasp", np.full(3, 255, np.uint8)))
    lines = len(drawn) + len(notes) + 1
    panel = np.full((LINE_HEIGHT * lines + 16, width, 3), 255, np.uint8)
    title = (
        f"{found.hand.name}: only the best grasp of each object is drawn, of "
        f"{counted(len(found.grasps), 'grasp')}; number: rank; colour: object; red ring: "
        "forbidden; palm: only of the first"
    )
    _write(panel, title if drawn else found.grasps.reason, 16, 0, INK)
    for row, one in enumerate(drawn, 1):
        grasp = one.grasp
        _swatch(panel, row, one.colour)
        text = (
            f"{one.rank}: object {grasp.object_label}, {1e3 * grasp.object_width:.0f} mm, "
            f"{grasp.side}, {100 * grasp.success:.0f} %"
        )
        if grasp.forbidden_by:
            text += f", forbidden: {'; '.join(grasp.forbidden_by)}"
        _write(panel, text, 44, row, INK)
    for row, (note, colour) in enumerate(notes, len(drawn) + 1):
        _swatch(panel, row, tuple(colour.tolist()))
        _write(panel, note, 44, row, FAINT)
    return panel


def _swatch(panel: NDArray[np.uint8], row: int, colour: tuple[int, ...]) -> None:
    top = LINE_HEIGHT * row + 14
    cv2.rectangle(panel, (16, top), (34, top + 18), colour, cv2.FILLED)


def _write(
    panel: NDArray[np.uint8], text: str, x: int, row: int, colour: tuple[int, int, int]
) -> None:
    place = (x, LINE_HEIGHT * row + 30)
    cv2.putText(panel, text, place, FONT, 0.6, colour, 1, cv2.LINE_AA)


def _draw_edges(
    picture: NDArray[np.uint8], box: NDArray[np.int32], colour: tuple[int, int, int], width: int
) -> None:
    for start, end in EDGES:
        line = box[[start, end]]
        cv2.polylines(picture, [line], False, colour, width, cv2.LINE_AA, SUBPIXEL)


def _tag(
    picture: NDArray[np.uint8], place: tuple[int, int], one: DrawnGrasp, *, scale: float
) -> None:
    """Write the rank at the end of the approach line, on a disc of its colour."""
    height, width = picture.shape[:2]
    radius = round(15 * scale)
    x = int(np.clip(place[0], radius, width - radius))
    y = int(np.clip(place[1], radius, height - radius))
    ring, edge = (DARK, 2) if one.grasp.safe else (FORBIDDEN, 5)
    cv2.circle(picture, (x, y), radius + edge, ring, cv2.FILLED, cv2.LINE_AA)
    cv2.circle(picture, (x, y), radius, one.colour, cv2.FILLED, cv2.LINE_AA)
    text, size = str(one.rank), 0.62 * scale
    (w, h), _ = cv2.getTextSize(text, FONT, size, 1)
    cv2.putText(picture, text, (x - w // 2, y + h // 2), FONT, size, DARK, 1, cv2.LINE_AA)
