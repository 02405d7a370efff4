"""Draw the worst fits of a run beside the true objects."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from eyehand.perception import outline
from eyehand.perception.io import atomic_write
from eyehand.perception.superquadric import mesh

from ...bench.chart_style import BLUE, DPI, GREY, INK, VERMILION, WIDTH

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path

    from matplotlib.axes import Axes
    from numpy.typing import NDArray

    from .mesh_trials import MeshTrial

COLUMNS = 3
"""Fits per row. Each has the image, the plan and the side view."""
PANEL, NAME = 0.86, 0.34
"""Side of a panel and height of its name, inches."""
MARGIN_PX = 12
"""Border around the object in the image, px."""
RESOLUTION = 32
"""Facets around a fitted solid."""
MAX_LETTERS = 52
"""Maximum length of the reason of a refusal in a name."""
SIZE = 5.5
"""Font size, points."""


def draw_worst(trials: Sequence[MeshTrial], path: Path, count: int) -> None:
    """Draw the `count` worst fits as a PNG: unsaid failures first, then by their IoU.

    The three panels of a fit are the depth image, the plan and a view from the side. The object is
    grey and the fit is blue, or red if the fit is refused.
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    worst = sorted(trials, key=_badness)[:count]
    rows = -(-len(worst) // COLUMNS)
    height = rows * (PANEL + NAME) + 0.1
    figure = Figure(figsize=(WIDTH, height), dpi=DPI, facecolor="white")
    FigureCanvasAgg(figure)
    cell = WIDTH / COLUMNS
    for index, trial in enumerate(worst):
        row, column = divmod(index, COLUMNS)
        bottom = height - (row + 1) * (PANEL + NAME)
        for panel, draw in enumerate((_draw_image, _draw_plan, _draw_side)):
            left = column * cell + 0.04 + panel * PANEL
            place = (left / WIDTH, bottom / height, (PANEL - 0.04) / WIDTH, PANEL / height)
            axes = figure.add_axes(place)
            axes.set_xticks([])
            axes.set_yticks([])
            for side in axes.spines.values():
                side.set_color(GREY)
            draw(axes, trial)
        top = (bottom + PANEL + 0.04) / height
        figure.text(
            (column * cell + 0.04) / WIDTH, top, _words(trial), size=SIZE, color=INK, va="bottom"
        )
    with atomic_write(path) as temporary, temporary.open("wb") as file:
        figure.savefig(file, format="png")


def _badness(trial: MeshTrial) -> tuple[bool, float]:
    score = trial.score
    return not (score.unsaid_iou or score.unsaid_unusable), score.iou


def _words(trial: MeshTrial) -> str:
    score = trial.score
    first = f"{trial.placed.mesh.key[:34]}, view {trial.view.view}"
    if score.refused:
        return f"{first}\nrefused: {score.reason[:MAX_LETTERS]}"
    use = "usable" if score.usable else "not usable"
    doubt = "flagged" if score.flagged else "no doubt stated"
    figures = f"IoU {100 * score.iou:.0f} %, width {1e3 * score.width_error:+.0f} mm"
    return f"{first}, parts {score.parts}\n{figures}, {use}, {doubt}"


def _colour(trial: MeshTrial) -> str:
    return VERMILION if trial.score.refused else BLUE


def _draw_image(axes: Axes, trial: MeshTrial) -> None:
    frame = trial.view.frame
    mask = trial.view.object_pixels == trial.label
    rows, columns = np.nonzero(mask)
    depth = np.where(frame.depth > 0, frame.depth, np.nan)
    near, far = np.nanquantile(depth[mask], [0.02, 0.98]) if mask.any() else (0.0, 1.0)
    axes.imshow(depth, cmap="gray_r", vmin=near - 0.05, vmax=far + 0.1)
    axes.contour(mask, [0.5], colors=[INK], linewidths=0.5)
    if frame.T_world_camera is not None:
        for part in trial.parts:
            polygon = outline(part, frame.intrinsics, frame.T_world_camera.inv())
            if polygon is not None:
                closed = np.vstack([polygon, polygon[:1]])
                axes.plot(*closed.T, color=_colour(trial), linewidth=0.8)
    if mask.any():
        half = max(np.ptp(rows), np.ptp(columns)) / 2 + MARGIN_PX
        middle = (rows.max() + rows.min()) / 2, (columns.max() + columns.min()) / 2
        axes.set_xlim(middle[1] - half, middle[1] + half)
        axes.set_ylim(middle[0] + half, middle[0] - half)


def _draw_plan(axes: Axes, trial: MeshTrial) -> None:
    """Draw the view from above, with the camera at the lower edge."""
    forward, right = _camera_axes(trial)
    _draw_projection(axes, trial, np.array([right, forward]))


def _draw_side(axes: Axes, trial: MeshTrial) -> None:
    """Draw the view from the side, with the camera at the left."""
    forward, _ = _camera_axes(trial)
    _draw_projection(axes, trial, np.array([forward, [0.0, 0.0, 1.0]]))


def _camera_axes(trial: MeshTrial) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the horizontal directions forward and right of the camera, (3,) each."""
    pose = trial.view.frame.T_world_camera
    right = np.array([1.0, 0.0, 0.0]) if pose is None else pose.rotation.as_matrix()[:, 0]
    return np.cross([0.0, 0.0, 1.0], right), right


def _draw_projection(axes: Axes, trial: MeshTrial, plane: NDArray[np.float64]) -> None:
    """Draw the projections of the object and the fit onto two directions (2, 3)."""
    from matplotlib.collections import PolyCollection
    from scipy.spatial import ConvexHull

    item = trial.placed
    flat = item.pose.apply(item.mesh.vertices) @ plane.T
    faces: Any = flat[item.mesh.faces]
    axes.add_collection(PolyCollection(faces, facecolors=GREY, edgecolors="none"))
    for part in trial.parts:
        corners = mesh(part, RESOLUTION)[0] @ plane.T
        ring = corners[ConvexHull(corners).vertices]
        closed = np.vstack([ring, ring[:1]])
        axes.plot(*closed.T, color=_colour(trial), linewidth=0.8)
    low, high = flat.min(axis=0), flat.max(axis=0)
    half = 0.75 * float((high - low).max())
    middle = (low + high) / 2
    axes.set_xlim(middle[0] - half, middle[0] + half)
    axes.set_ylim(middle[1] - half, middle[1] + half)
