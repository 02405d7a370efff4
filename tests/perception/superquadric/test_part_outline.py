"""Tests of the planes that touch the outline of a part."""

import numpy as np
import pytest
from scipy.spatial.transform import RigidTransform, Rotation

from eyehand.perception import Superquadric, perpendicular_pair
from eyehand.perception.superquadric import sample_surface
from eyehand.perception.superquadric.part_outline import DIRECTIONS, outline_planes

ORIGIN = np.array([0.1, -0.2, 0.7])
NOTHING = np.zeros((0, 2))


def view(seed: int) -> tuple[Superquadric, np.ndarray, np.ndarray]:
    """Return a solid, the positions of its surface in the image, and the image axes."""
    rng = np.random.default_rng(seed)
    pose = RigidTransform.from_rotation(Rotation.random(rng=rng))
    exponents = rng.uniform(0.3, 1.5, 2)
    solid = Superquadric(rng.uniform(0.02, 0.06, 3), (exponents[0], exponents[1]), pose)
    forward = -ORIGIN / np.linalg.norm(ORIGIN)
    frame = np.vstack([perpendicular_pair(forward), forward])
    local = (sample_surface(solid, 20000, rng) - ORIGIN) @ frame.T
    return solid, local[:, :2] / local[:, 2:], frame


@pytest.mark.parametrize("seed", range(6))
def test_planes_touch_the_solid_and_contain_the_camera(seed):
    solid, image, frame = view(seed)
    own = np.ones(len(image), dtype=bool)
    planes = outline_planes(image, own, np.arange(len(own)), NOTHING, frame, ORIGIN, 0.0, 0.01)
    assert len(planes) == DIRECTIONS
    assert np.linalg.norm(planes[:, :3], axis=1) == pytest.approx(1.0)
    assert planes[:, :3] @ ORIGIN + planes[:, 3] == pytest.approx(0.0, abs=1e-12)
    gaps = planes[:, :3] @ solid.centre + planes[:, 3] - solid.support(-planes[:, :3])
    assert np.abs(gaps).max() < 5e-4


def test_no_plane_touches_where_something_else_is_near():
    _, image, frame = view(0)
    own = image[:, 0] < np.median(image[:, 0])
    planes = outline_planes(image, own, np.arange(len(own)), NOTHING, frame, ORIGIN, 0.0, 0.01)
    assert 0 < len(planes) < DIRECTIONS
    # The other part lies towards larger x. No plane keeps the part out of there.
    assert (planes[:, :3] @ frame[0]).min() > -0.9
    around = outline_planes(
        image, own, np.arange(len(own)), 1.1 * image[own], frame, ORIGIN, 0.0, 0.01
    )
    assert len(around) < len(planes)
