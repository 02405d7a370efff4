"""Tests of planes found by their heights along a normal, and of the space below their edge."""

import numpy as np
import pytest
from synthetic_solids import CAMERA_HEIGHT, TABLE_AXES, Box, Plate, exact_image, solid_frame

from eyehand.perception.segmentation import SupportPlane
from eyehand.perception.segmentation.frame_noise import NoiseProfile
from eyehand.perception.segmentation.open_edges import open_share
from eyehand.perception.segmentation.parallel_planes import (
    MIN_COSINE,
    MIN_SLANT,
    FlatReadings,
    facing_readings,
    flat_readings,
    parallel_planes,
)
from eyehand.perception.segmentation.support_extent import locate_support

UP = TABLE_AXES[2]
NOISE = NoiseProfile(np.ones(1), np.full(1, 1e-3))


def read(solids, plates) -> FlatReadings:
    frame, _ = solid_frame(solids, plates)
    return flat_readings(exact_image(frame), NOISE)


def test_boards_are_found_at_their_heights():
    plates = (Plate(z=0.25, y=(0.7, 0.9)), Plate(y=(0.55, 0.9)), Plate(z=-0.3))
    planes = parallel_planes(read([], plates), UP)
    heights = sorted(CAMERA_HEIGHT - plane.offset for plane, _ in planes)
    assert heights == pytest.approx([-0.3, 0.0, 0.25], abs=2e-3)
    for plane, points in planes:
        assert np.abs(plane.height(points)).max() < 0.01


def test_faces_of_another_direction_are_not_counted():
    planes = parallel_planes(read([Box(0.0, 0.8, (0.2, 0.1, 0.2))], (Plate(),)), -TABLE_AXES[1])
    assert len(planes) == 1
    assert planes[0][1] @ TABLE_AXES[1] == pytest.approx(0.75, abs=2e-3)


def test_facing_readings_equal_numpy():
    rng = np.random.default_rng(0)
    points = rng.uniform([-0.5, -0.5, 0.5], [0.5, 0.5, 1.5], (200, 3))
    normals = UP + 0.4 * rng.normal(size=(200, 3))
    normals = (normals / np.linalg.norm(normals, axis=1)[:, None]).astype(np.float32)
    members, offsets, areas = facing_readings(FlatReadings(points, normals, 2e-6), UP)
    slant = -(points @ UP) / points[:, 2]
    expected = np.flatnonzero((normals @ UP > MIN_COSINE) & (slant > MIN_SLANT))
    assert expected.size > 10
    assert np.array_equal(members, expected)
    assert offsets == pytest.approx(-(points @ UP)[expected])
    assert areas == pytest.approx(2e-6 * points[expected, 2] ** 2 / slant[expected])


def test_image_without_readings_has_no_planes():
    nothing = FlatReadings(np.zeros((0, 3)), np.zeros((0, 3), np.float32), 1e-6)
    assert parallel_planes(nothing, UP) == []


@pytest.mark.parametrize(
    ("solids", "plates", "is_open"),
    [
        ([], (Plate((-0.2, 0.2), (0.6, 0.9)), Plate(z=-0.4)), True),
        ([Box(0.0, 0.75, (0.3, 0.2, 0.2))], (Plate(),), False),
    ],
    ids=["board", "top of a box"],
)
def test_space_below_a_front_edge(solids, plates, is_open):
    frame, _ = solid_frame(solids, plates)
    image = exact_image(frame)
    height = 0.2 if solids else 0.0
    support = locate_support(SupportPlane(UP, CAMERA_HEIGHT - height, 5e-4), 0.8, image)
    assert support is not None
    share = open_share(support.plane, support.hull, support.axes, image)
    assert share > 0.9 if is_open else share < 0.1
