"""Pictures of tactile images: a heat map with the contact's features."""

from __future__ import annotations

import math
from collections.abc import Callable

import cv2
import numpy as np
from numpy.typing import NDArray

from eyehand.tactile import ContactFeatures, TactileImage, tangents

SIZE = 480
"""Length of the picture's longer side, pixels."""
MIN_CONFIDENCE = 0.25
"""Confidence of the orientation from which the axis is drawn: the servo ignores a lower one."""
WHITE, MARK = (255, 255, 255), (255, 70, 60)


def touch_picture(
    image: TactileImage,
    features: ContactFeatures,
    full: float,
    side_force: NDArray[np.float64] | None = None,
) -> NDArray:
    """Draw pressures as a heat map with centre, long axis and side force, (H, W, 3) uint8 RGB.

    The sensor is seen from the object's side of its xy-plane, x to the right and y upwards.

    Parameters
    ----------
    image
        Pressures of any array.
    features
        Features of the contact.
    full
        Pressure of the brightest colour, Pa, > 0.
    side_force
        Tangential force, (2,), N; the arrow's length is its ratio to the normal force.
    """
    places = image.array.positions[:, :2]
    half = 0.5 * math.sqrt(image.array.area)
    low, high = places.min(axis=0) - half, places.max(axis=0) + half
    scale = SIZE / float((high - low).max())
    width, height = (math.ceil(scale * extent) for extent in high - low)

    def pixel(place: NDArray[np.float64]) -> tuple[int, int]:
        x, y = scale * (place[:2] - low)
        return round(float(x)), round(height - float(y))

    levels = np.clip(255.0 * image.pressures / full, 0, 255).astype(np.uint8)
    colours = cv2.applyColorMap(levels[None], cv2.COLORMAP_VIRIDIS)[0, :, ::-1]
    if image.array.grid is not None:
        cells = np.ascontiguousarray(colours.reshape(*image.array.grid, 3)[::-1])
        picture = cv2.resize(cells, (width, height), interpolation=cv2.INTER_NEAREST)
    else:
        picture = np.full((height, width, 3), 255, np.uint8)
        for place, area, colour in zip(places, image.array.areas, colours.tolist(), strict=True):
            radius = max(round(0.5 * scale * math.sqrt(area)), 1)
            cv2.circle(picture, pixel(place), radius, colour, -1, cv2.LINE_AA)
    if features:
        _draw_features(picture, features, pixel, side_force)
    return picture


def _draw_features(
    picture: NDArray,
    features: ContactFeatures,
    pixel: Callable[[NDArray[np.float64]], tuple[int, int]],
    side_force: NDArray[np.float64] | None,
) -> None:
    centre = features.centre
    if features.confidence >= MIN_CONFIDENCE:
        # The length shows the confidence.
        half = features.confidence * math.sqrt(features.area)
        x, y = tangents(features.normal)
        axis = half * (math.cos(features.orientation) * x + math.sin(features.orientation) * y)
        cv2.line(picture, pixel(centre - axis), pixel(centre + axis), WHITE, 2, cv2.LINE_AA)
    if side_force is not None:
        tip = centre[:2] + 0.02 * side_force / features.force
        cv2.arrowedLine(picture, pixel(centre), pixel(tip), MARK, 2, cv2.LINE_AA)
    cv2.drawMarker(picture, pixel(centre), MARK, cv2.MARKER_CROSS, 18, 2, cv2.LINE_AA)
