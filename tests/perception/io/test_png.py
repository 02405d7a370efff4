"""Tests of PNG images: integrity, pixel type and channel order."""

from __future__ import annotations

import zlib
from pathlib import Path

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from eyehand.errors import InputError
from eyehand.perception.io.png import check_png, decode_colour, decode_depth, decode_mask, write_png


def _encode(image: np.ndarray) -> bytes:
    return cv2.imencode(".png", image)[1].tobytes()


RAMP = np.arange(60 * 80, dtype=np.uint16).reshape(60, 80) * 13


def test_sixteen_bit_depth_round_trips(tmp_path: Path) -> None:
    write_png(tmp_path / "a.png", RAMP)
    data = (tmp_path / "a.png").read_bytes()
    assert check_png(data).kind == "16-bit greyscale"
    np.testing.assert_array_equal(decode_depth(data), RAMP)


def test_colour_channel_order_is_rgb(tmp_path: Path) -> None:
    red = np.zeros((2, 3, 3), dtype=np.uint8)
    red[..., 0] = 200
    write_png(tmp_path / "a.png", red)
    np.testing.assert_array_equal(decode_colour((tmp_path / "a.png").read_bytes()), red)
    bgr = cv2.imread(str(tmp_path / "a.png"))
    assert bgr is not None
    assert bgr[0, 0].tolist() == [0, 0, 200]


def test_alpha_and_palette_are_read_as_rgb() -> None:
    bgra = np.zeros((2, 3, 4), dtype=np.uint8)
    bgra[...] = [1, 2, 3, 255]
    np.testing.assert_array_equal(decode_colour(_encode(bgra)), np.full((2, 3, 3), [3, 2, 1]))


@pytest.mark.parametrize(
    ("image", "kind"),
    [
        (np.ones((2, 2), dtype=np.uint8), "8-bit greyscale"),
        (np.ones((2, 2, 3), dtype=np.uint8), "8-bit RGB"),
        (np.ones((2, 2, 4), dtype=np.uint16), "16-bit RGBA"),
    ],
)
def test_wrong_depth_type_is_reported(image: np.ndarray, kind: str) -> None:
    with pytest.raises(InputError, match=f"the depth image is {kind}, expected 16-bit greyscale"):
        decode_depth(_encode(image))


@settings(deadline=None)
@given(st.data())
def test_truncated_image_is_rejected(data: st.DataObject) -> None:
    whole = _encode(RAMP)
    keep = data.draw(st.integers(8, len(whole) - 1))
    with pytest.raises(InputError, match=f"truncated: it ends after {keep} bytes"):
        decode_depth(whole[:keep])


@settings(deadline=None)
@given(st.data())
def test_flipped_bit_is_rejected(data: st.DataObject) -> None:
    damaged = bytearray(_encode(RAMP))
    at = data.draw(st.integers(0, len(damaged) - 1))
    damaged[at] ^= 1 << data.draw(st.integers(0, 7))
    with pytest.raises(InputError, match=r"not a PNG file|damaged|truncated"):
        decode_depth(bytes(damaged))


def test_decoder_prints_no_warnings(capfd: pytest.CaptureFixture[str]) -> None:
    whole = _encode(RAMP)
    for keep in range(0, len(whole), 97):
        with pytest.raises(InputError):
            decode_depth(whole[:keep])
    assert capfd.readouterr() == ("", "")


def test_other_image_format_is_rejected() -> None:
    with pytest.raises(InputError, match="not a PNG file: it begins with b'BM"):
        decode_depth(cv2.imencode(".bmp", np.ones((2, 2), dtype=np.uint8))[1].tobytes())


def test_huge_image_is_rejected_by_its_header(capfd: pytest.CaptureFixture[str]) -> None:
    whole = _encode(RAMP)
    header = whole[12:16] + (20_000).to_bytes(4, "big") * 2 + whole[24:29]
    data = whole[:12] + header + zlib.crc32(header).to_bytes(4, "big") + whole[33:]
    for decode in (decode_depth, decode_colour):
        with pytest.raises(InputError, match=r"20000x20000 px, expected at most 8\.4 megapixels"):
            decode(data)
    assert capfd.readouterr() == ("", "")


@pytest.mark.parametrize("kind", ["uint8", "uint16", "bgr", "bgra"])
def test_mask_holds_the_pixels_that_are_not_black(kind: str) -> None:
    mask = RAMP % 3 == 0
    channels = {"bgr": [0, 0, 1], "bgra": [1, 0, 0, 255]}
    if kind in channels:
        image = (mask[..., None] * np.array(channels[kind])).astype(np.uint8)
        image[..., 3:] = 255
    else:
        image = mask.astype(kind)
    np.testing.assert_array_equal(decode_mask(_encode(image)), mask)


def test_empty_image_is_rejected(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="does not fit a PNG"):
        write_png(tmp_path / "a.png", np.ones((2, 0), dtype=np.uint16))
