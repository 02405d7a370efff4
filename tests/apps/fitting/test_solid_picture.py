"""Pictures show the points and the solid, with OpenGL and without."""

import cv2
import numpy as np
import pytest

from eyehand.apps.fitting import gl_panels
from eyehand.apps.fitting.panel_look import SOLID
from eyehand.apps.fitting.solid_picture import fit_picture


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
    picture = decoded(fit_picture(lens, gl=False))
    height = len(picture)
    above, below = picture[: height // 2], picture[height // 2 : int(0.9 * height)]
    assert picture.shape[1] == 1600
    assert bluish(below) > bluish(above) + 0.1


def test_opengl_draws_the_same_sides(lens):
    if not gl_panels.gl_works():
        pytest.skip("no OpenGL here")
    flat, drawn = (decoded(fit_picture(lens, gl=gl)) for gl in (False, True))
    assert drawn.shape == flat.shape
    # The panels differ in shading alone: where one shows the object the other does too.
    full = [picture[:, 150:].std(axis=2) > 6 for picture in (flat, drawn)]
    overlap = (full[0] & full[1]).sum() / (full[0] | full[1]).sum()
    assert overlap > 0.7


def test_a_cloud_without_a_solid_is_drawn_with_the_reason(unfit, lens):
    picture = decoded(fit_picture(unfit, gl=False))
    assert len(picture) < len(decoded(fit_picture(lens, gl=False)))


def test_pictures_are_the_same_each_time(can):
    assert fit_picture(can, gl=False) == fit_picture(can, gl=False)


@pytest.mark.parametrize("program", ["import os; os.abort()", "raise SystemExit(3)"])
def test_a_machine_where_opengl_crashes_is_found_out_in_a_child(program, monkeypatch):
    monkeypatch.setattr(gl_panels, "_PROBE", program)
    assert not gl_panels.gl_works.__wrapped__()
