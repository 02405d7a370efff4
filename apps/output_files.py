"""Output files: folders, text, pictures, and the three files of a perceived frame."""

from __future__ import annotations

import json
import struct
import zlib
from typing import TYPE_CHECKING

import cv2

from eyehand.errors import InputError
from eyehand.perception.io import atomic_write

from .scene_json import scene_json
from .scene_picture import labels_picture, overlay_picture

if TYPE_CHECKING:
    from pathlib import Path

    import numpy as np
    from numpy.typing import NDArray

    from .perceived_frame import PerceivedFrame

HEADER_END = 33
"""Length of a PNG's signature and header chunk, bytes."""


def write_perceived_frame(folder: Path, found: PerceivedFrame, source: str) -> list[Path]:
    """Write scene.json, labels.png and overlay.png to a folder, and return their paths.

    Raises
    ------
    InputError
        If the folder cannot be created or written to.
    """
    make_folder(folder)
    scene_file = folder / "scene.json"
    text = json.dumps(scene_json(found.scene, found.plans, source), indent=1, allow_nan=False)
    write_text(scene_file, text + "\n")
    labels_file, overlay_file = folder / "labels.png", folder / "overlay.png"
    write_picture(labels_file, labels_picture(found.scene.segmentation.labels))
    write_picture(overlay_file, overlay_picture(found.frame, found.scene, found.plans))
    return [scene_file, labels_file, overlay_file]


def make_folder(folder: Path) -> None:
    """Create an output folder with its parents.

    Raises
    ------
    InputError
        If it cannot be created.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"cannot create the folder {folder}: {error.strerror}") from error


def write_text(path: Path, text: str) -> None:
    """Write a UTF-8 text file atomically."""
    with atomic_write(path) as temporary:
        temporary.write_text(text, encoding="utf-8")


def write_picture(
    path: Path, picture: NDArray[np.uint8] | NDArray[np.uint16], *, pixels_per_metre: int = 0
) -> None:
    """Write an image (H, W) or (H, W, 3) RGB as a PNG file atomically.

    The resolution, if not 0, is the one at which programs print the picture.
    """
    if picture.ndim == 3:
        picture = picture[..., ::-1]
    with atomic_write(path) as temporary:
        ok, encoded = cv2.imencode(".png", picture)
        if not ok:
            raise InputError(f"cannot encode a picture of shape {picture.shape} as PNG")
        data = encoded.tobytes()
        if pixels_per_metre:
            chunk = b"pHYs" + struct.pack(">IIB", pixels_per_metre, pixels_per_metre, 1)
            chunk = struct.pack(">I", 9) + chunk + struct.pack(">I", zlib.crc32(chunk))
            data = data[:HEADER_END] + chunk + data[HEADER_END:]
        temporary.write_bytes(data)
