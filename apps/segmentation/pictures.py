"""Draw segmented frames beside their truth: a picture per frame, and one sheet of all."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import cv2
import numpy as np

from eyehand.apps.scene_picture import background_picture, colour_of
from eyehand.perception.io import atomic_write

from ..bench.chart_style import FAINT, INK

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path

    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from numpy.typing import NDArray

    from eyehand.perception import DepthFrame

    from .score import SegmentationScore

DPI = 100
PANEL_WIDTH = 8.0
"""Width of truth or prediction in the picture of one frame, inches."""
SHEET_WIDTH = 4.0
"""Width of truth or prediction on the sheet, inches."""
SHEET_COLUMNS = 2
"""Frames side by side on the sheet."""
GAP, HEADER = 0.08, 0.36
"""Space between panels, and over them for the title, inches."""
TITLE, TAG = 13.0, 10.0
"""Font sizes, points."""
SHEET_TITLE = 9.0
ZOOM_WIDTH = 1280
"""Minimum width of the image on which outlines are drawn, px, for smooth lines."""
TINT = 0.38
"""Opacity of the object colour."""
BACKGROUND = 0.7
"""Brightness of the background image."""
WRONG = np.array([235, 20, 60], np.uint8)
"""Colour of unmatched objects and segments. No matched object has this red."""
MIN_VIEW = 0.45
"""Minimum width of the shown crop, share of the image width."""
VIEW_MARGIN = 0.06
"""Margin around the objects in the crop, share of the image width."""
TAG_HALF_WIDTH = 0.022
"""Half width of an object that a tag fits into, share of the crop width."""


@dataclass(frozen=True)
class ScoredFrame:
    """A frame with truth, prediction and score."""

    name: str
    """Title."""
    frame: DepthFrame
    """The background."""
    truth: NDArray[np.int32]
    """(H, W): 0 = no object."""
    predicted: NDArray[np.int32]
    """(H, W): 0 = no object."""
    score: SegmentationScore
    """Score of the prediction."""


def verdict(score: SegmentationScore) -> str:
    """Return the score of a frame as one line of text."""
    mistakes = [
        f"{count} {name}"
        for name, count in (
            ("over", score.over),
            ("under", score.under),
            ("missed", score.missed),
            ("false", score.false),
        )
        if count
    ]
    good = round(score.found * score.truth_count)
    segments = f"{score.predicted_count} segment{'' if score.predicted_count == 1 else 's'}"
    return (
        f"F {100 * score.f:.1f} %, boundary F {100 * score.boundary_f:.1f} %, "
        f"{good} of {score.truth_count} found in {segments}"
        + (f": {', '.join(mistakes)}" if mistakes else "")
    )


def write_frame_picture(path: Path, shown: ScoredFrame) -> None:
    """Write truth and prediction side by side (PNG), matched objects in the same colour.

    Every matched segment shows its F in %. Unmatched ones are red, with a word. An object is
    ``missed``, or ``merged`` into the segment of another object. A segment is ``false``, or a
    ``part`` of an object that has another segment.

    Raises
    ------
    InputError
        If the folder does not exist or cannot be written to.
    DeviceError
        If the disk fails.
    """
    figure = _figure(2 * PANEL_WIDTH + GAP, HEADER + PANEL_WIDTH * _aspect(shown))
    _draw_pair(figure, shown, (0.0, 0.0), PANEL_WIDTH, TITLE, verdict(shown.score), tags=True)
    _write(figure, path)


def write_sheet(path: Path, shown: Sequence[ScoredFrame]) -> None:
    """Write the frames, two side by side, each as truth and prediction (PNG).

    Raises
    ------
    InputError
        If the folder does not exist or cannot be written to.
    DeviceError
        If the disk fails.
    """
    columns = min(SHEET_COLUMNS, len(shown))
    rows = [shown[start : start + columns] for start in range(0, len(shown), columns)]
    heights = [HEADER + SHEET_WIDTH * max(_aspect(item) for item in row) for row in rows]
    wide = 2 * SHEET_WIDTH + GAP
    figure = _figure(columns * wide + (columns - 1) * 3 * GAP, sum(heights))
    below = sum(heights)
    for row, height in zip(rows, heights, strict=True):
        below -= height
        for column, item in enumerate(row):
            score = item.score
            note = (
                f"F {100 * score.f:.0f}, boundary {100 * score.boundary_f:.0f}, "
                f"{score.predicted_count} for {score.truth_count}"
            )
            corner = (column * (wide + 3 * GAP), below)
            _draw_pair(figure, item, corner, SHEET_WIDTH, SHEET_TITLE, note, tags=False)
    _write(figure, path)


def outlined(
    background: NDArray[np.uint8], labels: NDArray[np.int32], colours: dict[int, NDArray[np.uint8]]
) -> NDArray[np.uint8]:
    """Tint and outline objects on a darkened, enlarged image, (H', W', 3) uint8 RGB.

    Parameters
    ----------
    background
        (H, W, 3) uint8 RGB.
    labels
        (H, W); 0 = no object.
    colours
        Colour of each label, (3,) uint8 RGB.
    """
    height, width = labels.shape
    zoom = max(-(-ZOOM_WIDTH // width), 1)
    canvas = BACKGROUND * background.astype(np.float32)
    for label, colour in colours.items():
        mask = labels == label
        canvas[mask] = (1 - TINT) * canvas[mask] / BACKGROUND + TINT * colour
    canvas = np.clip(canvas, 0, 255).astype(np.uint8)
    size = (width * zoom, height * zoom)
    canvas = np.ascontiguousarray(cv2.resize(canvas, size, interpolation=cv2.INTER_CUBIC))
    for label, colour in colours.items():
        mask = (labels == label).astype(np.uint8)
        mask = cv2.resize(mask, size, interpolation=cv2.INTER_NEAREST)
        lines, _ = cv2.findContours(mask, cv2.RETR_CCOMP, cv2.CHAIN_APPROX_NONE)
        bright = (0.25 * 255 + 0.75 * colour).astype(int).tolist()
        cv2.drawContours(canvas, lines, -1, (15, 15, 18), 4, cv2.LINE_AA)
        cv2.drawContours(canvas, lines, -1, bright, 2, cv2.LINE_AA)
    return canvas.astype(np.uint8)


def _draw_pair(
    figure: Figure,
    shown: ScoredFrame,
    corner: tuple[float, float],
    width: float,
    size: float,
    note: str,
    *,
    tags: bool,
) -> None:
    """Draw truth and prediction under a title; `corner` is the lower left corner, inches."""
    total_width, total_height = figure.get_size_inches()
    left, bottom = corner
    height = width * _aspect(shown)
    view = _view(shown)
    background = background_picture(shown.frame)[view]
    true_colours, found_colours = _colours(shown)
    sides = (
        ("truth", shown.truth[view], true_colours, _truth_tags(shown)),
        ("found", shown.predicted[view], found_colours, _predicted_tags(shown)),
    )
    for side, (name, labels, colours, words) in enumerate(sides):
        x = left + side * (width + GAP)
        axes = figure.add_axes(
            (x / total_width, bottom / total_height, width / total_width, height / total_height)
        )
        picture = outlined(background, labels, colours)
        pixels = (round(width * DPI), round(height * DPI))
        shrunk = cv2.resize(picture, pixels, interpolation=cv2.INTER_AREA)
        # figimage does not rescale. Scaling by matplotlib takes a second.
        figure.figimage(np.asarray(shrunk), round(x * DPI), round(bottom * DPI), zorder=-1)
        axes.set_xlim(0, labels.shape[1])
        axes.set_ylim(labels.shape[0], 0)
        axes.set_axis_off()
        place = {"ha": "left", "va": "bottom", "color": "white", "size": size - 2}
        axes.text(0.012, 0.016, name, transform=axes.transAxes, **place)
        if tags:
            for label, (word, wrong) in words.items():
                _write_tag(axes, labels == label, word, wrong=wrong)
    line = (bottom + height + 0.5 * HEADER) / total_height
    start, end = (left + 0.1) / total_width, (left + 2 * width + GAP - 0.1) / total_width
    figure.text(start, line, shown.name, size=size, weight="bold", color=INK, va="center")
    figure.text(end, line, note, size=size, color=FAINT, va="center", ha="right")


def _colours(
    shown: ScoredFrame,
) -> tuple[dict[int, NDArray[np.uint8]], dict[int, NDArray[np.uint8]]]:
    """Return the colours of objects and segments. Matched pairs share one, others are red."""
    true_colours = dict.fromkeys(_labels(shown.truth), WRONG)
    found_colours = dict.fromkeys(_labels(shown.predicted), WRONG)
    for rank, match in enumerate(shown.score.matches, start=1):
        true_colours[match.truth] = found_colours[match.predicted] = colour_of(rank)
    return true_colours, found_colours


def _view(shown: ScoredFrame) -> tuple[slice, slice]:
    """Return the crop around all objects and segments, with the aspect ratio of the image."""
    height, width = shown.truth.shape
    rows, columns = np.nonzero((shown.truth > 0) | (shown.predicted > 0))
    if rows.size == 0:
        return slice(0, height), slice(0, width)
    margin = VIEW_MARGIN * width
    wide = max(np.ptp(columns) + 2 * margin, MIN_VIEW * width)
    wide = min(max(wide, (np.ptp(rows) + 2 * margin) * width / height), width)
    size = (max(round(wide * height / width), 1), max(round(wide), 1))
    sides = []
    for places, extent, limit in zip((rows, columns), size, (height, width), strict=True):
        middle = (int(places.min()) + int(places.max())) / 2
        start = int(np.clip(round(middle - extent / 2), 0, limit - extent))
        sides.append(slice(start, start + extent))
    return sides[0], sides[1]


def _truth_tags(shown: ScoredFrame) -> dict[int, tuple[str, bool]]:
    """Return the word for each true object without a segment, and whether it is a mistake."""
    matched = {match.truth for match in shown.score.matches}
    tags = {}
    for label in _labels(shown.truth):
        if label not in matched:
            inside = shown.predicted[shown.truth == label]
            tags[label] = ("missed" if np.median(inside > 0) < 1 else "merged", True)
    return tags


def _predicted_tags(shown: ScoredFrame) -> dict[int, tuple[str, bool]]:
    """Return the word for each segment, and whether it is a mistake."""
    f = {match.predicted: match.f for match in shown.score.matches}
    tags = {}
    for label in _labels(shown.predicted):
        if label in f:
            tags[label] = (f"{100 * f[label]:.0f}", False)
        else:
            inside = shown.truth[shown.predicted == label]
            tags[label] = ("false" if np.median(inside > 0) < 1 else "part", True)
    return tags


def _write_tag(axes: Axes, mask: NDArray[np.bool_], word: str, *, wrong: bool) -> None:
    # The pixel farthest from the border lies on the object, also on a bent one.
    depth = cv2.distanceTransform(np.pad(mask, 1).astype(np.uint8), cv2.DIST_L2, 3)[1:-1, 1:-1]
    row, column = np.unravel_index(int(np.argmax(depth)), mask.shape)
    inside = depth.max() > TAG_HALF_WIDTH * mask.shape[1]
    top = int(np.flatnonzero(mask.any(axis=1))[0])
    axes.annotate(
        word,
        (column + 0.5, (row if inside else top) + 0.5),
        xytext=(0, 0 if inside else TAG),
        textcoords="offset points",
        size=TAG,
        color="white",
        weight="bold",
        ha="center",
        va="center",
        bbox={
            "boxstyle": "round,pad=0.25",
            "facecolor": "#D1123AE6" if wrong else "#15171ACC",
            "edgecolor": "none",
        },
    )


def _labels(image: NDArray[np.int32]) -> list[int]:
    return [int(label) for label in np.unique(image) if label > 0]


def _aspect(shown: ScoredFrame) -> float:
    height, width = shown.truth.shape
    return height / width


def _figure(width: float, height: float) -> Figure:
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(width, height), dpi=DPI, facecolor="white")
    FigureCanvasAgg(figure)
    return figure


def _write(figure: Figure, path: Path) -> None:
    with atomic_write(path) as temporary:
        figure.savefig(temporary, dpi=DPI, metadata={"Software": None})
