"""A moving picture for web pages: a perceived depth frame beside the film of a demo."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from eyehand.errors import DeviceError, InputError
from eyehand.perception.io import atomic_write

from .grasp.film_frame import BACKGROUND, cell_size
from .grasp.frame_crop import crop_to_objects
from .perceived_frame import PerceivedFrame
from .scene_picture import depth_picture, overlay_picture

WIDTH = 960
"""Width of the moving picture, px. A page of GitHub shows at most about 900."""
STEP = 3
"""Every third image of the film is shown, for three times as long. The file stays small."""
DEPTH_SECONDS = 2.0
"""Duration for which the depth image is shown before its segments and solids, s."""
QUALITY = 75
"""WebP quality, 1 to 100. Lines and letters stay sharp, and 15 s take about 0.5 MB."""


def write_moving_picture(path: Path, film: Path, found: PerceivedFrame) -> None:
    """Write an animated WebP that repeats: a frame on the left, the cell of a film on the right.

    The left shows the depth image, then its segments and solids. The caption of the film is below.

    Parameters
    ----------
    path
        The .webp file.
    film
        A finished film of the demo.
    found
        The perceived frame.

    Raises
    ------
    InputError
        If the film cannot be read or the folder cannot be written to.
    DeviceError
        If the picture cannot be encoded.
    """
    images, pause = _film_images(film)
    high = cell_size((images[0].shape[1], images[0].shape[0]))[1]
    frame, scene = crop_to_objects(found.frame, found.scene)
    before = _scaled(depth_picture(frame), high)
    after = _scaled(overlay_picture(frame, scene, found.plans, names=False), high)
    change = round(1000 * DEPTH_SECONDS / pause)
    animation = cv2.Animation()
    animation.frames = [
        cv2.cvtColor(_beside(before if index < change else after, image), cv2.COLOR_RGB2BGR)
        for index, image in enumerate(images)
    ]
    animation.durations = [pause] * len(images)
    with atomic_write(path) as temporary:
        options = [cv2.IMWRITE_WEBP_QUALITY, QUALITY]
        if not cv2.imwriteanimation(str(temporary), animation, options):
            raise DeviceError(f"the moving picture {path} cannot be encoded")


def _film_images(film: Path) -> tuple[list[NDArray[np.uint8]], int]:
    """Read every `STEP`-th image of a film, (H, W, 3) uint8 RGB, and their duration in ms."""
    read = cv2.VideoCapture(str(film))
    rate = read.get(cv2.CAP_PROP_FPS)
    images = [image for index, image in enumerate(_images(read)) if index % STEP == 0]
    read.release()
    if not images or not rate > 0:
        raise InputError(f"{film} must be a film with at least one image")
    return images, round(1000 * STEP / rate)


def _images(read: cv2.VideoCapture) -> Iterator[NDArray[np.uint8]]:
    while True:
        fine, image = read.read()
        if not fine:
            return
        yield np.asarray(cv2.cvtColor(image, cv2.COLOR_BGR2RGB), dtype=np.uint8)


def _beside(left: NDArray[np.uint8], image: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """Put a picture beside the cell of an image of the film, above its caption strip."""
    tall, wide = image.shape[:2]
    across, high = cell_size((wide, tall))
    canvas = np.empty((tall, left.shape[1] + across, 3), np.uint8)
    canvas[:] = BACKGROUND
    canvas[:high, : left.shape[1]] = left
    canvas[:high, left.shape[1] :] = image[:high, wide - across :]
    strip = min(wide, canvas.shape[1])
    canvas[high:, -strip:] = image[high:, -strip:]
    height = round(tall * WIDTH / canvas.shape[1])
    smaller = cv2.resize(canvas, (WIDTH, height), interpolation=cv2.INTER_AREA)
    return np.asarray(smaller, dtype=np.uint8)


def _scaled(picture: NDArray[np.uint8], height: int) -> NDArray[np.uint8]:
    """Scale a picture to a height, px."""
    width = max(round(picture.shape[1] * height / picture.shape[0]), 1)
    scaled = cv2.resize(picture, (width, height), interpolation=cv2.INTER_AREA)
    return np.asarray(scaled, dtype=np.uint8)
