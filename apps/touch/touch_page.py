"""The live page of a tactile sensor: heat map, features, and a button that zeroes it."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from eyehand.tactile import ContactFeatures, TactileImage, tangents
from eyehand.tactile.sensors import ContactReading, ContactSensor

from ..fitting.page_server import HOST, close_server, open_server

TITLE = "eyehand touch"
UPDATE_SECONDS = 0.05
"""Wall time between two updates of the page, s."""
MESSAGE_SECONDS = 4.0
"""Wall time for which a message stays, s."""
MIN_FULL = 200.0
"""Minimum pressure of the brightest colour, Pa: noise alone stays dark."""
FADE = 0.98
"""Factor of that pressure per update, until the present maximum is reached."""

SIZE = 480
"""Length of the picture's longer side, pixels."""
MIN_CONFIDENCE = 0.25
"""Confidence of the orientation from which the axis is drawn: the servo ignores a lower one."""
WHITE, MARK = (255, 255, 255), (255, 70, 60)


class TouchPage:
    """A page that shows a sensor. Use it as a context.

    Parameters
    ----------
    contact
        The calibrated sensor.
    unit
        Unit of pressures: "Pa", or "counts" without calibration.
    port
        Port of the page. If it is taken, the next free port is used.

    Raises
    ------
    InputError
        If no port can be opened.
    """

    def __init__(self, contact: ContactSensor, unit: str, port: int) -> None:
        self._contact, self._unit = contact, unit
        self._server = open_server(port, TITLE)
        gui: Any = self._server.gui
        gui.configure_theme(show_logo=False, show_share_button=False, control_width="large")
        info = contact.sensor.info
        gui.add_markdown(
            f"### {info.name}\n{len(info.array.positions)} tactels, {info.bits} bits, "
            f"{info.rate:g} images per second"
        )
        self._picture = gui.add_image(np.zeros((SIZE, SIZE, 3), np.uint8), format="png")
        self.text: Any = gui.add_markdown("No image yet.")
        """The line of features below the picture."""
        self.zero: Any = gui.add_button("zero", hint="nothing may touch the sensor")
        self.zero.on_click(lambda _: setattr(self, "zero_wanted", True))
        self.zero_wanted = False
        """Whether the button was pressed."""
        self._full, self._shown = MIN_FULL, 0.0
        self._message, self._message_end = "", 0.0

    @property
    def address(self) -> str:
        """URL of the page."""
        return f"http://{HOST}:{self._server.get_port()}"

    def __enter__(self) -> TouchPage:
        return self

    def __exit__(self, *error: object) -> None:
        close_server(self._server)

    def show(self, reading: ContactReading) -> None:
        """Show a reading, at most 20 times a second."""
        now = time.monotonic()
        if now - self._shown < UPDATE_SECONDS:
            return
        self._shown = now
        image = self._contact.image
        self._full = max(float(image.pressures.max()), FADE * self._full, MIN_FULL)
        # The arrow is the ratio of two forces. Without calibration the normal force is unknown.
        side_force = reading.side_force if self._unit == "Pa" else None
        with self._server.atomic():
            self._picture.image = touch_picture(image, reading.features, self._full, side_force)
            self.text.content = self._message if now < self._message_end else self._text(reading)

    def say(self, message: str) -> None:
        """Show a message in place of the features for some seconds."""
        self._message, self._message_end = message, time.monotonic() + MESSAGE_SECONDS
        self.text.content = message

    def _text(self, reading: ContactReading) -> str:
        f, unit = reading.features, self._unit
        lines = [f"brightest colour: {self._full:.0f} {unit}"]
        if reading.fault:
            lines.insert(0, f"**{reading.fault.replace('_', ' ')}**")
        if not f:
            return "\n\n".join(["no contact", *lines])
        x, y = 1e3 * f.centre[:2]
        force = f"{f.force:.2f} N" if unit == "Pa" else "not calibrated"
        rows = [
            ("force", force),
            ("pressure", f"{f.pressure:.0f} {unit}"),
            ("centre", f"{x:+.1f}, {y:+.1f} mm"),
            ("area", f"{1e4 * f.area:.2f} cm²"),
            ("direction", f"{np.degrees(f.orientation):+.0f}° (confidence {f.confidence:.2f})"),
            ("border, saturated", f"{100 * f.border_share:.0f} %, {f.saturated}"),
        ]
        if reading.side_force is not None:
            sx, sy = reading.side_force
            rows.append(("side force", f"{sx:+.2f}, {sy:+.2f} N"))
        table = ["| feature | value |", "| --- | --- |", *(f"| {a} | {b} |" for a, b in rows)]
        return "\n".join([*lines, "", *table])


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
