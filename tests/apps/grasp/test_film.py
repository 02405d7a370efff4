"""A film is written whole, at its pace, with what happens told in it."""

from __future__ import annotations

from dataclasses import dataclass
from types import SimpleNamespace

import cv2
import numpy as np
import pytest

from eyehand.apps.grasp.film import Film, FilmOptions
from eyehand.apps.grasp.film_frame import INSET_SHARE, STRIP, Caption, film_frame, inset_of
from eyehand.apps.grasp.stage_camera import StageCamera
from eyehand.apps.grasp.trial import GraspTrial, cell_of
from eyehand.data_synth.gl_probe import gl_fault
from eyehand.errors import InputError

SIZE = (320, 180)


@dataclass
class Grey:
    """A camera before a grey wall."""

    closed: bool = False

    def picture(self):
        """See the wall."""
        return np.full((SIZE[1], SIZE[0], 3), 128, np.uint8)

    def close(self):
        """Note the end."""
        self.closed = True


def moment(time: float, phase: str):
    reading = SimpleNamespace(time=time)
    return SimpleNamespace(phase=phase, reading=reading, force=np.array([0, 4.0, 0, 9, 1]))


def test_ten_pictures_become_a_film_slower_where_fingers_move(tmp_path):
    camera, path = Grey(), tmp_path / "short.mp4"
    options = FilmOptions(size=SIZE, end_seconds=0.04, pace=4.0, hands_on_pace=2.0)
    recorder = SimpleNamespace(frame=None)
    with Film(path, options) as film:
        film.film(camera, recorder)  # pyright: ignore[reportArgumentType] - all that it asks for
        for step in range(160):
            phase = "lift" if step < 80 else "close"
            film.watch(moment(0.004 * step, phase))  # pyright: ignore[reportArgumentType] - too
        assert film.frames == 2 + 4
        assert not path.exists()
    assert camera.closed
    read = cv2.VideoCapture(str(path))
    assert int(read.get(cv2.CAP_PROP_FRAME_COUNT)) == 7
    assert read.get(cv2.CAP_PROP_FPS) == pytest.approx(25)
    fine, picture = read.read()
    assert fine
    assert picture.shape == (SIZE[1], SIZE[0], 3)
    assert picture[-STRIP // 2, SIZE[0] // 2].mean() < picture[60, 300].mean() - 50
    assert list(tmp_path.iterdir()) == [path]


def test_an_error_leaves_no_film(tmp_path):
    def fail() -> None:
        with Film(tmp_path / "none.mp4", FilmOptions(size=SIZE)) as film:
            film.film(Grey(), SimpleNamespace(frame=None))  # pyright: ignore[reportArgumentType]
            film.watch(moment(0.0, "lift"))  # pyright: ignore[reportArgumentType] - as above
            raise ValueError("stop")

    with pytest.raises(ValueError, match="stop"):
        fail()
    assert list(tmp_path.iterdir()) == []


def test_force_bars_grow_with_the_force_and_the_picture_given_is_kept():
    plain = np.full((540, 960, 3), 200, np.uint8)
    caption = Caption("grip", "pick 1: box", "0 in the tray", 2.0)
    weak = film_frame(plain, caption, None, np.array([0.0, 0, 0, 0, 0]))
    strong = film_frame(plain, caption, None, np.array([0.0, 15, 0, 0, 0]))
    assert (plain == 200).all()
    changed = (weak != strong).any(axis=2)
    assert 300 < changed.sum() < 2000
    inset = inset_of(np.zeros((300, 400, 3), np.uint8), 960, "seen")
    wide = round(INSET_SHARE * 960)
    assert inset.shape == (round(0.75 * wide), wide, 3)


@pytest.mark.parametrize("wrong", [{"fps": 0}, {"pace": -1.0}, {"size": (321, 180)}])
def test_options_out_of_range_are_refused(wrong):
    with pytest.raises(InputError):
        FilmOptions(**wrong)


@pytest.mark.skipif(bool(gl_fault()), reason="no OpenGL here")
def test_the_stage_camera_sees_robot_and_table_and_leaves_the_model_as_it_was(single):
    _, robot = cell_of(single.objects, GraspTrial(family="single"))
    before = robot.model.vis.quality.numslices
    camera = StageCamera(robot, SIZE)
    picture = camera.picture()
    camera.close()
    assert robot.model.vis.quality.numslices == before
    assert picture.shape == (SIZE[1], SIZE[0], 3)
    red, _, blue = picture[-40:].reshape(-1, 3).mean(axis=0)
    assert red > blue + 30  # the table's wood
    assert picture[:60].std() > 20
