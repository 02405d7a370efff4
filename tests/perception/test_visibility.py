"""Tests of the empty space around an object in a depth frame."""

import numpy as np
import pytest
from scipy import ndimage
from scipy.spatial.transform import RigidTransform, Rotation
from synthetic_balls import CAMERA, ball_centre, ball_frame

from eyehand.perception import DepthFrame, Superquadric, perceive, view_free_space
from eyehand.perception.superquadric import covered_share
from eyehand.perception.visibility import EDGE_PX, nearest_readings

BALL = (0.0, 0.65, 0.05)


def ball(scale: float) -> Superquadric:
    centre = RigidTransform.from_translation(ball_centre(*BALL))
    return Superquadric(np.full(3, scale * BALL[2]), (1.0, 1.0), centre, "sphere")


def test_true_ball_covers_no_free_space_and_larger_ones_do():
    frame, truth = ball_frame([BALL])
    free_space = view_free_space(truth == 1, frame, RigidTransform.identity())
    shares = [covered_share([ball(scale)], free_space, 0.002) for scale in (1.0, 1.1, 1.3)]
    assert shares[0] == 0.0
    assert shares[0] < 0.1 < shares[1] < shares[2]


def test_rays_meet_the_readings():
    frame, truth = ball_frame([BALL])
    T = RigidTransform.from_components([0.3, -0.2, 0.6], Rotation.from_rotvec([0.1, 2.0, -0.4]))
    free_space = view_free_space(truth == 1, frame, T)
    points = T.inv().apply(free_space.origin + free_space.depth[:, None] * free_space.rays)
    known = free_space.depth > 0
    columns, rows = np.round(CAMERA.project(points[known])).astype(int).T
    assert np.array_equal(free_space.on_object[known], truth[rows, columns] == 1)
    # Each depth is the smallest reading near the pixel.
    assert (points[known][:, 2] <= frame.depth[rows, columns] + 1e-6).all()
    assert np.median(frame.depth[rows, columns] - points[known][:, 2]) < 0.01
    assert 500 < len(free_space.rays) < 1800


def test_pixels_without_a_reading_show_nothing():
    frame, truth = ball_frame([BALL])
    frame = DepthFrame(np.where(truth == 1, frame.depth, np.float32(0)), CAMERA, None)
    free_space = view_free_space(truth == 1, frame, RigidTransform.identity())
    assert np.all((free_space.depth > 0) <= free_space.on_object)
    assert covered_share([ball(1.5)], free_space, 0.05) == 0.0


def test_empty_mask_gives_no_rays():
    frame, truth = ball_frame([BALL])
    free_space = view_free_space(truth == 7, frame, RigidTransform.identity())
    assert len(free_space.rays) == 0
    assert covered_share([ball(1.0)], free_space, 0.0) == 0.0


@pytest.mark.parametrize("dtype", [np.uint8, np.int32, np.float64])
def test_masks_of_numbers_equal_those_of_bool(dtype):
    frame, truth = ball_frame([BALL])
    one, other = (
        view_free_space(mask, frame, RigidTransform.identity())
        for mask in (truth == 1, (truth == 1).astype(dtype))
    )
    np.testing.assert_array_equal(one.rays, other.rays)
    np.testing.assert_array_equal(one.on_object, other.on_object)


def test_perceived_ball_covers_nothing():
    frame, _ = ball_frame([BALL])
    (item,) = perceive(frame).objects
    assert item.fit
    assert item.fit.covered_share == pytest.approx(0.0, abs=0.01)


@pytest.mark.parametrize("step", [1, 3, 4])
def test_nearest_readings_equal_numpy(step):
    rng = np.random.default_rng(step)
    readings = np.where(rng.random((41, 38)) < 0.2, 0.0, rng.uniform(0.5, 1.0, (41, 38)))
    mask = np.indices(readings.shape).sum(axis=0) < 40

    def nearest(counted):
        kept = np.where(counted & (readings > 0), readings, np.inf)
        return ndimage.minimum_filter(kept, 2 * EDGE_PX + 1, mode="constant", cval=np.inf)

    expected = np.where(mask, nearest(mask), nearest(readings > 0))
    expected = np.where(readings > 0, expected, 0.0)[step // 2 :: step, step // 2 :: step]
    assert np.array_equal(nearest_readings(readings, mask, step // 2, step), expected)
