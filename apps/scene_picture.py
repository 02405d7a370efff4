"""Pictures of a perceived frame: label image, depth image, and overlay with solids and grasps."""

from __future__ import annotations

import colorsys
from typing import TYPE_CHECKING

import cv2
import numpy as np
from scipy.spatial.transform import RigidTransform

from eyehand.perception import outline, outline_points

from .drawn_solids import drawn_solids, solid_curves
from .scene_json import fit_parts

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from eyehand.grasping import GraspPlan
    from eyehand.perception import DepthFrame, Scene, SceneObject, Superquadric, SuperquadricFit

PALETTE = np.array(
    [
        (86, 180, 233),
        (230, 159, 0),
        (0, 158, 115),
        (204, 121, 167),
        (240, 228, 66),
        (213, 94, 0),
        (0, 114, 178),
        (148, 103, 189),
        (140, 200, 90),
        (220, 120, 120),
    ],
    dtype=np.uint8,
)
"""The colour-blind-safe colours of Okabe and Ito, and four more."""
GOLDEN = 0.618034
"""Hue step of the labels beyond the palette. The golden ratio keeps successive hues apart."""
BEYOND = ((0.30, 0.95), (0.85, 0.60))
"""Alternating saturation and value of the labels beyond the palette."""

MIN_WIDTH = 1280
"""Minimum width of a picture, px. Smaller ones are enlarged to keep lines and text sharp."""
MAX_HEIGHT = 2880
"""Maximum height of an enlarged picture, px."""
TINT = 0.45
BACKGROUND = 0.75
MIN_VISIBLE_SHARE = 0.25
"""Minimum visible share of a drawn solid. A less visible one would cover the measured points."""
LINE = 2
FINER = 8
"""Number of segments per edge of an outline. Each can be hidden."""
COVER_STEPS = 100
"""Number of samples between a point and the camera for occlusion by another part."""
SUBPIXEL = 4
"""Bits of sub-pixel precision in OpenCV's line drawing."""


def labels_picture(labels: NDArray[np.int32]) -> NDArray[np.uint16]:
    """Return the labels as a 16-bit image (H, W). 0 is background."""
    return labels.astype(np.uint16)


def overlay_picture(
    frame: DepthFrame, scene: Scene, plans: dict[int, GraspPlan], *, names: bool = True
) -> NDArray[np.uint8]:
    """Draw segments, projected solids and grasps over a frame, (H', W', 3) uint8 RGB.

    The background is the colour image if there is one, else the depth image. The lines are the
    outlines and the visible feature lines of all parts of each solid. Without `names`, the plans
    are not needed.
    """
    height, width = frame.depth.shape
    zoom = max(min(-(-MIN_WIDTH // width), MAX_HEIGHT // height), 1)
    canvas = background_picture(frame).astype(np.float32)
    labels = scene.segmentation.labels
    mean = canvas.mean(axis=2, keepdims=True)
    canvas = BACKGROUND * (0.5 * canvas + 0.5 * mean)
    for item in scene.objects:
        mask = labels == item.label
        canvas[mask] = (1 - TINT) * canvas[mask] / BACKGROUND + TINT * colour_of(item.label)
    canvas = np.clip(canvas, 0, 255).astype(np.uint8)
    size = (canvas.shape[1] * zoom, canvas.shape[0] * zoom)
    canvas = cv2.resize(canvas, size, interpolation=cv2.INTER_CUBIC)
    T_scene_camera = frame.T_world_camera
    T_camera_scene = RigidTransform.identity() if T_scene_camera is None else T_scene_camera.inv()
    for item in reversed(scene.objects):
        _draw_solid(canvas, item, frame, T_camera_scene, zoom)
    taken: list[tuple[int, int, int, int]] = []
    for item in scene.objects if names else ():
        _write(canvas, item, plans[item.label], labels, zoom, taken)
    return canvas


def background_picture(frame: DepthFrame) -> NDArray[np.uint8]:
    """Return the colour image, or the depth image if there is none, (H, W, 3) uint8 RGB."""
    if frame.colour is not None:
        return np.array(frame.colour)
    return depth_picture(frame)


def depth_picture(frame: DepthFrame) -> NDArray[np.uint8]:
    """Draw depth from near (bright) to far (dark), (H, W, 3) uint8 RGB. No reading is black."""
    near, far = np.percentile(frame.depth[frame.valid], [1, 99])
    span = max(float(far - near), 1e-6)
    shade = np.clip(1.0 - (frame.depth - near) / span, 0.0, 1.0)
    grey = (50 + 190 * shade).astype(np.uint8)
    coloured = np.asarray(cv2.applyColorMap(grey, cv2.COLORMAP_BONE))[..., ::-1]
    return np.ascontiguousarray(np.where(frame.valid[..., None], coloured, 0)).astype(np.uint8)


def colour_of(label: int) -> NDArray[np.uint8]:
    """Return the colour of a label, (3,) uint8 RGB. Each label has its own."""
    if 1 <= label <= len(PALETTE):
        return PALETTE[label - 1]
    saturation, value = BEYOND[label % len(BEYOND)]
    shade = colorsys.hsv_to_rgb(label * GOLDEN % 1.0, saturation, value)
    return np.round(255 * np.array(shade)).astype(np.uint8)


def covered(
    points: NDArray[np.float64], solids: tuple[Superquadric, ...], eye: NDArray[np.float64]
) -> NDArray[np.bool_]:
    """Return a mask (N,) of the points (N, 3) inside or behind one of the solids."""
    covered = np.zeros(len(points), dtype=bool)
    towards = (eye - points) / np.linalg.norm(eye - points, axis=1, keepdims=True)
    for solid in solids:
        # No part of the solid is farther away than its far side.
        reach = np.linalg.norm(points - solid.centre, axis=1) + np.linalg.norm(solid.semi_axes)
        steps = np.linspace(0.0, 1.0, COVER_STEPS) * reach[:, None]
        samples = points[:, None] + steps[..., None] * towards[:, None]
        covered |= solid.contains(samples).any(axis=1)
    return covered


def _draw_solid(
    canvas: NDArray[np.uint8],
    item: SceneObject,
    frame: DepthFrame,
    T_camera_scene: RigidTransform,
    zoom: int,
) -> None:
    if not item.fit or item.visible_share < MIN_VISIBLE_SHARE:
        return
    bright = _bright(item.label)
    eye = T_camera_scene.inv().translation
    parts, drawn = fit_parts(item.fit), drawn_solids(item.fit)
    for index, solid in enumerate(parts):
        others = parts[:index] + parts[index + 1 :]
        for curve in solid_curves(drawn[index]):
            facing = np.einsum("ij,ij->i", drawn[index].normals(curve), eye - curve) > 0
            pixels = frame.intrinsics.project(T_camera_scene.apply(curve))
            shown = facing & np.all(np.isfinite(pixels), axis=1) & ~covered(curve, others, eye)
            _draw_runs(canvas, pixels, shown, bright, zoom)
        polygon = outline(solid, frame.intrinsics, T_camera_scene)
        if polygon is None:
            continue
        if not others:
            _polyline(canvas, polygon, bright, zoom, closed=True)
            continue
        polygon = np.vstack([polygon, polygon[:1]])
        rim = outline_points(solid, polygon, frame.intrinsics, T_camera_scene)
        polygon, rim = _finer(polygon), _finer(rim)
        _draw_runs(canvas, polygon, ~covered(rim, others, eye), bright, zoom)


def _finer(curve: NDArray[np.float64]) -> NDArray[np.float64]:
    """Interpolate a curve (K, D), so that its visible part can end between two points."""
    places = np.linspace(0.0, len(curve) - 1.0, FINER * (len(curve) - 1) + 1)
    return np.column_stack([np.interp(places, np.arange(len(curve)), x) for x in curve.T])


def _draw_runs(
    canvas: NDArray[np.uint8],
    pixels: NDArray[np.float64],
    shown: NDArray[np.bool_],
    colour: tuple[int, int, int],
    zoom: int,
) -> None:
    """Draw the shown runs, mask (K,), of a curve (K, 2)."""
    for run in np.split(np.arange(len(pixels)), np.flatnonzero(np.diff(shown)) + 1):
        if shown[run[0]] and len(run) > 1:
            _polyline(canvas, pixels[run], colour, zoom, closed=False)


def _polyline(
    canvas: NDArray[np.uint8],
    pixels: NDArray[np.float64],
    colour: tuple[int, int, int],
    zoom: int,
    *,
    closed: bool,
) -> None:
    # Pixel centres have integer coordinates before and after the enlargement.
    enlarged = (pixels + 0.5) * zoom - 0.5
    limit = 4.0 * max(canvas.shape)
    fixed = np.round(np.clip(enlarged, -limit, limit) * (1 << SUBPIXEL)).astype(np.int32)
    cv2.polylines(canvas, [fixed], closed, (20, 20, 20), LINE + 2, cv2.LINE_AA, SUBPIXEL)
    cv2.polylines(canvas, [fixed], closed, colour, LINE, cv2.LINE_AA, SUBPIXEL)


def _write(
    canvas: NDArray[np.uint8],
    item: SceneObject,
    plan: GraspPlan,
    labels: NDArray[np.int32],
    zoom: int,
    taken: list[tuple[int, int, int, int]],
) -> None:
    """Write number, solid and grasp above an object, clear of the earlier names."""
    rows, columns = np.nonzero(labels == item.label)
    kind = _name(item.fit)
    grasp = plan.prototype or "no grasp"
    text = f"{item.label} {kind} - {grasp}"
    scale, thickness = 0.55, 1
    (width, height), base = cv2.getTextSize(text, cv2.FONT_HERSHEY_DUPLEX, scale, thickness)
    x = int(np.median(columns) * zoom - width / 2)
    y = int(rows.min() * zoom - 10)
    x = int(np.clip(x, 4, canvas.shape[1] - width - 4))
    y = int(np.clip(y, height + 6, canvas.shape[0] - base - 4))
    step = height + base + 10
    for shift in (0, -1, 1, -2, 2, -3, 3):
        box = (x - 5, y + shift * step - height - 5, x + width + 5, y + shift * step + base + 2)
        inside = box[1] >= 0 and box[3] < canvas.shape[0]
        if inside and not any(_overlap(box, other) for other in taken):
            break
    else:
        box = (x - 5, y - height - 5, x + width + 5, y + base + 2)
    taken.append(box)
    corner, opposite = box[:2], box[2:]
    x, y = corner[0] + 5, opposite[1] - base - 2
    cv2.rectangle(canvas, corner, opposite, (25, 25, 28), cv2.FILLED, cv2.LINE_AA)
    cv2.putText(
        canvas,
        text,
        (x, y),
        cv2.FONT_HERSHEY_DUPLEX,
        scale,
        _bright(item.label),
        thickness,
        cv2.LINE_AA,
    )


def _name(fit: SuperquadricFit) -> str:
    if fit.superquadric is None or not fit:
        return "no solid"
    parts = len(fit_parts(fit))
    if fit.vessel is not None:
        return "ring" if fit.vessel.through else "vessel"
    return f"{parts} parts" if parts > 1 else fit.superquadric.kind


def _overlap(a: tuple[int, int, int, int], b: tuple[int, int, int, int]) -> bool:
    return a[0] < b[2] and b[0] < a[2] and a[1] < b[3] and b[1] < a[3]


def _bright(label: int) -> tuple[int, int, int]:
    r, g, b = (0.35 * 255 + 0.65 * colour_of(label)).astype(int).tolist()
    return r, g, b
