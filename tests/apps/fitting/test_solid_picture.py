"""Pictures of fits."""

import cv2
import numpy as np

from eyehand.apps.fitting.panel_style import SOLID
from eyehand.apps.fitting.solid_picture import fit_picture


def decoded(png: bytes) -> np.ndarray:
    picture = cv2.imdecode(np.frombuffer(png, np.uint8), cv2.IMREAD_COLOR)
    assert picture is not None
    return picture[..., ::-1].astype(int)


def bluish(picture: np.ndarray) -> float:
    """Return the share of pixels with about the hue of the solid."""
    red, green, blue = (int(SOLID[k : k + 2], 16) for k in (1, 3, 5))
    assert blue > green > red
    hue = (picture[..., 2] - picture[..., 0] > 12) & (picture[..., 2] > 120)
    return float(hue.mean())


def test_picture_shows_points_above_and_the_solid_below(lens):
    picture = decoded(fit_picture(lens))
    height = len(picture)
    above, below = picture[: height // 2], picture[height // 2 : int(0.9 * height)]
    assert picture.shape[1] == 1600
    assert bluish(below) > bluish(above) + 0.1


def test_cloud_without_a_solid_gives_a_smaller_picture(unfit, lens):
    picture = decoded(fit_picture(unfit))
    assert len(picture) < len(decoded(fit_picture(lens)))


def test_pictures_are_reproducible(can):
    assert fit_picture(can) == fit_picture(can)
