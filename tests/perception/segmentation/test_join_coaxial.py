"""Tests of joining necks to the bodies below them."""

import numpy as np
import pytest
from synthetic_solids import Ball, Box, exact_image, solid_frame

from eyehand.perception import CameraIntrinsics, perpendicular_pair
from eyehand.perception.segmentation import SegmentationOptions
from eyehand.perception.segmentation.ambiguity import COAXIAL
from eyehand.perception.segmentation.join_coaxial import (
    MIN_SLOPE,
    _is_neck,
    _Region,
    join_coaxial,
    region_readings,
)
from eyehand.perception.segmentation.local_planes import fit_local_planes
from eyehand.perception.segmentation.result import SupportPlane

CAMERA = CameraIntrinsics(600.0, 600.0, 319.5, 239.5, 640, 480)
TABLE = SupportPlane(np.array([0.0, -0.8, -0.6]), 0.6, 0.002)
BODY = Ball(0.0, 0.65, 0.06, 0.06)


def join(*solids):
    """Return the number of objects after the join, and the uncertain pairs."""
    frame, truth = solid_frame(solids, camera=CAMERA)
    image = exact_image(frame)
    planes = fit_local_planes(image, SegmentationOptions())
    joined, uncertain = join_coaxial(truth, image, planes, TABLE)
    assert np.array_equal(joined > 0, truth > 0)
    return joined.max(), uncertain


@pytest.mark.parametrize(
    ("upper", "objects"),
    [
        (Ball(0.0, 0.65, 0.13, 0.025), 1),
        (Ball(0.0, 0.65, 0.16, 0.045), 2),
    ],
)
def test_narrow_part_on_a_sloping_shoulder_is_joined_and_a_wide_one_reported(upper, objects):
    count, uncertain = join(BODY, upper)
    assert count == objects
    assert [one.reason for one in uncertain] == [COAXIAL] * (objects - 1)


@pytest.mark.parametrize(
    "solids",
    [
        (BODY, Ball(0.03, 0.63, 0.13, 0.025)),
        (BODY, Ball(0.12, 0.65, 0.025, 0.025)),
        (Box(0.0, 0.65, (0.1, 0.1, 0.1), yaw=0.6), Ball(0.0, 0.65, 0.125, 0.025)),
        (Box(0.0, 0.65, (0.1, 0.1, 0.1)), Box(0.0, 0.65, (0.04, 0.04, 0.05), base=0.1)),
    ],
)
def test_parts_without_a_common_axis_stay_as_they_are(solids):
    assert join(*solids) == (2, [])


@pytest.mark.parametrize(("slope", "joined"), [(0.0, False), (0.6, True)])
def test_flat_ring_around_the_upper_part_is_no_shoulder(slope, joined):
    def ring(low, high, height):
        radius, angle = np.meshgrid(np.linspace(low, high, 20), np.linspace(0.0, 3.0, 20))
        plan = (radius * [np.cos(angle), np.sin(angle)]).reshape(2, -1).T
        level = height - slope * np.maximum(radius.ravel() - 0.012, 0.0)
        return _Region(level, plan, plan[:0], plan[:0])

    neck, body = ring(0.0, 0.012, 0.2), ring(0.012, 0.035, 0.15)
    assert _is_neck(neck, body, np.zeros(2)) == joined


def test_readings_equal_numpy():
    frame, truth = solid_frame([BODY], camera=CAMERA)
    image = exact_image(frame)
    planes = fit_local_planes(image, SegmentationOptions())
    pixels = np.flatnonzero(truth == 1)[::40].astype(np.int32)
    # These pixels have no reading or no plane.
    image.disparity.flat[pixels[3]] = planes.value.flat[pixels[5]] = 0.0
    axes = np.vstack([TABLE.normal, perpendicular_pair(TABLE.normal)])
    height, plan, wall, outwards = region_readings(
        pixels, image.disparity, planes, image.pinhole, axes, TABLE.offset
    )
    pixels = np.delete(pixels, [3, 5])
    rows, columns = np.divmod(pixels, truth.shape[1])
    points = image.points(rows, columns)
    slope_u, slope_v = (slope.flat[pixels].astype(float) for slope in planes[1:3])
    back = (
        planes.value.flat[pixels] - slope_u * (columns - CAMERA.cx) - slope_v * (rows - CAMERA.cy)
    )
    normals = -np.column_stack([slope_u * CAMERA.fx, slope_v * CAMERA.fy, back])
    across = (normals / np.linalg.norm(normals, axis=1)[:, None]) @ axes[1:].T
    slope = np.linalg.norm(across, axis=1)
    steep = slope > MIN_SLOPE
    assert 0 < np.count_nonzero(steep) < len(pixels)
    np.testing.assert_allclose(height, TABLE.height(points), atol=1e-12)
    np.testing.assert_allclose(plan, points @ axes[1:].T, atol=1e-12)
    np.testing.assert_allclose(wall, plan[steep], atol=1e-12)
    np.testing.assert_allclose(outwards, across[steep] / slope[steep, None], atol=1e-12)
