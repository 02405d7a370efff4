"""The moving picture: a perceived frame beside the film of a demo."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
import pytest

from eyehand.apps.demo import demo
from eyehand.apps.grasp.film import SIZE, _open_writer
from eyehand.apps.moving_picture import STEP, WIDTH, write_moving_picture
from eyehand.apps.perceived_frame import perceive_and_plan
from eyehand.errors import InputError
from eyehand.perception import read_frame

SAMPLE = Path(__file__).parents[3] / "apps/sample/depth.png"
IMAGES = 7 * 25
"""Number of images of the film, 7 s."""


@pytest.fixture(scope="module")
def found():
    return perceive_and_plan(read_frame(SAMPLE))


@pytest.fixture
def film(tmp_path):
    """A film whose cell turns from dark to bright."""
    path = tmp_path / "demo.mp4"
    writer = _open_writer(path, SIZE)
    for index in range(IMAGES):
        writer.send(np.full((SIZE[1], SIZE[0], 3), 40 + index, np.uint8))
    writer.close()
    return path


def test_picture_repeats_and_takes_as_long_as_film(tmp_path, film, found):
    path = tmp_path / "demo.webp"
    write_moving_picture(path, film, found)
    fine, moving = cv2.imreadanimation(str(path))
    assert fine
    assert moving.loop_count == 0
    assert np.sum(moving.durations) == pytest.approx(40 * IMAGES, abs=40 * STEP)
    first, last = moving.frames[0][..., :3], moving.frames[-1][..., :3]
    height, width = first.shape[:2]
    assert width == WIDTH
    assert 300 < height < 480
    cell = slice(0, height // 2), slice(3 * width // 4, width)
    assert last[cell].mean() > first[cell].mean() + 100
    left = slice(0, height // 2), slice(0, width // 3)
    colourful = [np.ptp(image[left].astype(int), axis=2) > 90 for image in (first, last)]
    assert colourful[1].sum() > colourful[0].sum() + 500
    assert sorted(tmp_path.iterdir()) == [film, path]


def test_unreadable_film_leaves_no_picture(tmp_path, found):
    film = tmp_path / "demo.mp4"
    film.write_bytes(b"no film")
    with pytest.raises(InputError, match="must be a film"):
        write_moving_picture(tmp_path / "demo.webp", film, found)
    assert list(tmp_path.iterdir()) == [film]


@pytest.mark.parametrize("other", [{"video": False}, {"view": True}])
def test_picture_without_film_is_refused(tmp_path, other):
    with pytest.raises(InputError, match="--beside needs the film"):
        demo(beside=SAMPLE, out=tmp_path / "out", **other)
    assert not (tmp_path / "out").exists()
