"""Pictures show the points and the solid, with OpenGL and without."""

import cv2
import numpy as np
import pytest

from eyehand.apps.fitting.gl_child import GlChild
from eyehand.apps.fitting.panel_look import SOLID
from eyehand.apps.fitting.picture_scene import picture_scene
from eyehand.apps.fitting.solid_picture import fit_picture
from eyehand.data_synth.render import gl_fault


def decoded(png: bytes) -> np.ndarray:
    picture = cv2.imdecode(np.frombuffer(png, np.uint8), cv2.IMREAD_COLOR)
    assert picture is not None
    return picture[..., ::-1].astype(int)


def bluish(picture: np.ndarray) -> float:
    """Share of the pixels that have about the solid's hue."""
    red, green, blue = (int(SOLID[k : k + 2], 16) for k in (1, 3, 5))
    assert blue > green > red
    hue = (picture[..., 2] - picture[..., 0] > 12) & (picture[..., 2] > 120)
    return float(hue.mean())


def test_the_flat_picture_shows_points_above_and_the_solid_below(lens):
    picture = decoded(fit_picture(lens))
    height = len(picture)
    above, below = picture[: height // 2], picture[height // 2 : int(0.9 * height)]
    assert picture.shape[1] == 1600
    assert bluish(below) > bluish(above) + 0.1


def test_opengl_draws_the_same_sides(lens):
    if gl_fault():
        pytest.skip(f"no OpenGL here: {gl_fault()}")
    with GlChild() as gl:
        flat, drawn = decoded(fit_picture(lens)), decoded(fit_picture(lens, gl))
    assert not np.array_equal(flat, drawn)
    # The panels differ in shading alone: where one shows the object the other does too.
    full = [picture[:, 150:].std(axis=2) > 6 for picture in (flat, drawn)]
    assert (full[0] & full[1]).sum() > 0.7 * (full[0] | full[1]).sum()


def test_opengl_is_not_tried_where_it_is_forbidden(lens, monkeypatch):
    monkeypatch.setenv("MUJOCO_GL", "disable")
    with GlChild() as gl:
        assert gl.panels(picture_scene(lens)) is None


def test_a_cloud_without_a_solid_is_drawn_with_the_reason(unfit, lens):
    picture = decoded(fit_picture(unfit))
    assert len(picture) < len(decoded(fit_picture(lens)))


def test_pictures_are_the_same_each_time(can):
    assert fit_picture(can) == fit_picture(can)


@pytest.mark.parametrize("program", ["import os; os.abort()", "raise SystemExit(3)", "print(1)"])
def test_where_opengl_crashes_the_picture_is_drawn_flat(program, can):
    with GlChild(program) as gl:
        assert fit_picture(can, gl) == fit_picture(can)
        assert gl.panels(picture_scene(can)) is None


def test_a_driver_that_hangs_is_given_up(monkeypatch, can):
    monkeypatch.setattr("eyehand.apps.fitting.gl_child.TIMEOUT_S", 0.2)
    with GlChild("import time; time.sleep(30)") as gl:
        assert gl.panels(picture_scene(can)) is None
