"""PNG images. Every chunk is checked before the image is decoded."""

from __future__ import annotations

import zlib
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from eyehand.errors import InputError

from ..frame import check_image_size

SIGNATURE = b"\x89PNG\r\n\x1a\n"
"""First eight bytes of every PNG file."""

GREYSCALE = 0
"""PNG colour type of single-channel images."""

COLOUR_TYPES = {0: "greyscale", 2: "RGB", 3: "palette", 4: "greyscale with alpha", 6: "RGBA"}
"""PNG colour types, PNG specification section 11.2.2."""


@dataclass(frozen=True)
class PngHeader:
    """Size and type of a PNG image."""

    width: int
    """Columns, px."""
    height: int
    """Rows, px."""
    bit_depth: int
    """Bits per channel."""
    colour_type: int
    """A key of `COLOUR_TYPES`."""

    @property
    def kind(self) -> str:
        """Return a readable name such as '16-bit greyscale'."""
        name = COLOUR_TYPES.get(self.colour_type, f"colour type {self.colour_type}")
        return f"{self.bit_depth}-bit {name}"


def check_png(data: bytes) -> PngHeader:
    """Check all chunks of a PNG file and return its header.

    Decoders return the upper part of a truncated image and zeros below, without an error. Depth
    readings would be lost without notice.

    Raises
    ------
    InputError
        If the bytes are not PNG, end before the image does, or fail a chunk's checksum, or if the
        image is larger than `MAX_PIXELS`.
    """
    if not data.startswith(SIGNATURE):
        raise InputError(f"not a PNG file: it begins with {data[:8]!r}, expected {SIGNATURE!r}")
    header = None
    at = len(SIGNATURE)
    while True:
        length = int.from_bytes(data[at : at + 4], "big")
        end = at + 12 + length
        if len(data) < max(end, at + 12):
            raise InputError(
                f"the PNG file is truncated: it ends after {len(data)} bytes, before its IEND chunk"
            )
        kind = data[at + 4 : at + 8]
        stored = int.from_bytes(data[end - 4 : end], "big")
        if zlib.crc32(data[at + 4 : end - 4]) != stored:
            raise InputError(
                f"the PNG file is damaged: checksum of its {kind!r} chunk at byte {at}"
            )
        if header is None:
            if kind != b"IHDR" or length != 13:
                raise InputError(f"the PNG file is damaged: first chunk {kind!r}, expected b'IHDR'")
            body = data[at + 8 : end - 4]
            size = (int.from_bytes(body[:4], "big"), int.from_bytes(body[4:8], "big"))
            check_image_size(*size)
            header = PngHeader(*size, body[8], body[9])
        if kind == b"IEND":
            return header
        at = end


def decode_depth(data: bytes) -> NDArray[np.uint16]:
    """Decode a 16-bit greyscale PNG, (H, W) uint16.

    Raises
    ------
    InputError
        If the image has another type, or cannot be decoded.
    """
    header = check_png(data)
    if header.bit_depth != 16 or header.colour_type != GREYSCALE:
        raise InputError(f"the depth image is {header.kind}, expected 16-bit greyscale")
    return _decode(data, cv2.IMREAD_UNCHANGED).astype(np.uint16, copy=False)


def decode_colour(data: bytes) -> NDArray[np.uint8]:
    """Decode a PNG of any type, (H, W, 3) uint8 RGB.

    Raises
    ------
    InputError
        If the image cannot be decoded.
    """
    check_png(data)
    bgr = _decode(data, cv2.IMREAD_COLOR | cv2.IMREAD_IGNORE_ORIENTATION)
    return np.ascontiguousarray(bgr[..., ::-1]).astype(np.uint8, copy=False)


def decode_mask(data: bytes) -> NDArray[np.bool_]:
    """Decode a PNG of any type to a mask (H, W) of the pixels that are not black.

    Raises
    ------
    InputError
        If the image cannot be decoded.
    """
    check_png(data)
    image = _decode(data, cv2.IMREAD_UNCHANGED)
    # The fourth channel is alpha.
    return np.asarray(image[..., :3].any(axis=2) if image.ndim == 3 else image > 0)


def write_png(path: Path, image: NDArray) -> None:
    """Write (H, W) uint16 as greyscale or (H, W, 3) uint8 RGB as colour.

    Raises
    ------
    InputError
        If the encoder refuses the image.
    OSError
        If the file cannot be written.
    """
    bgr = image[..., ::-1] if image.ndim == 3 else image
    try:
        done, encoded = cv2.imencode(".png", np.ascontiguousarray(bgr))
    except cv2.error as error:
        raise InputError(f"{image.shape} {image.dtype} does not fit a PNG: {error.err}") from error
    if not done:
        raise InputError(f"{image.shape} {image.dtype} does not fit a PNG")
    path.write_bytes(encoded.tobytes())


def _decode(data: bytes, flags: int) -> NDArray:
    try:
        image = cv2.imdecode(np.frombuffer(data, dtype=np.uint8), flags)
    except cv2.error as error:
        raise InputError(
            f"the PNG file cannot be decoded: {' '.join(error.err.split())}"
        ) from error
    if image is None:
        raise InputError("the PNG file cannot be decoded: its image data are damaged")
    return image
