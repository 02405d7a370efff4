"""Tests of containers: walls around the whole floor make one, walls at one side do not."""

import numpy as np
import pytest
from synthetic_solids import CAMERA_HEIGHT, TABLE_AXES, Box, Plate, exact_image, solid_frame

from eyehand.perception.segmentation import SupportPlane
from eyehand.perception.segmentation.enclosed_floor import (
    MAX_OFFSET,
    MIN_FACING,
    MIN_RISE,
    PROBES,
    is_enclosed,
    probe_walls,
)
from eyehand.perception.segmentation.support_extent import locate_support

PLANE = SupportPlane(TABLE_AXES[2], CAMERA_HEIGHT, 0.0005)
FLOOR = Plate((-0.2, 0.2), (0.5, 0.9))


def walls(height):
    """Return four walls around the floor; the near one is low, so that the floor is visible."""
    return [
        Box(-0.21, 0.7, (0.02, 0.44, height)),
        Box(0.21, 0.7, (0.02, 0.44, height)),
        Box(0.0, 0.49, (0.4, 0.02, 0.012)),
        Box(0.0, 0.91, (0.4, 0.02, height)),
    ]


def is_container(solids, floor=FLOOR):
    frame, _ = solid_frame(solids, (floor, Plate(z=-0.4)))
    image = exact_image(frame)
    support = locate_support(PLANE, 0.8, image)
    assert support is not None
    return is_enclosed(support, image)


@pytest.mark.parametrize("height", [0.012, 0.05, 0.15])
def test_walls_all_around_make_a_container(height):
    assert is_container(walls(height))


def test_walls_at_three_sides_make_none():
    three = walls(0.1)
    del three[1]
    assert not is_container(three)


def test_open_table_is_none():
    assert not is_container([Box(0.0, 0.7, (0.1, 0.1, 0.1))])


def test_table_beyond_the_image_is_none():
    assert not is_container([], Plate((-5.0, 5.0), (-5.0, 5.0)))


def test_answer_is_a_bool():
    assert isinstance(is_container(walls(0.05)), bool)
    assert not isinstance(is_container(walls(0.05)), np.bool_)


def test_board_whose_front_edge_is_outside_the_image_is_none():
    shelf = walls(0.1)
    shelf[2] = Box(-0.21, 0.4, (0.02, 1.0, 0.1))
    shelf += [Box(0.21, 0.4, (0.02, 1.0, 0.1))]
    assert not is_container(shelf, Plate((-0.2, 0.2), (-0.2, 0.9)))


def probed_with_numpy(hull, normals, counts, plane, axes, image):
    """Return the result of `probe_walls` from NumPy."""
    side = np.repeat(np.arange(len(hull)), counts)
    along = np.concatenate([(np.arange(count) + 0.5) / count for count in counts])
    places = hull[side] + along[:, None] * (np.roll(hull, -1, axis=0) - hull)[side]
    outwards = normals[side]
    towards = -np.einsum("ij,ij->i", places, outwards) / np.linalg.norm(places, axis=1)
    front = towards > MIN_FACING
    visible, k = front.copy(), image.intrinsics
    rows, columns = image.depth.shape
    rises, probed = np.zeros((2, len(places)), bool)
    for distance in PROBES:
        plan = places + distance * outwards
        points = plan @ axes - plane.offset * plane.normal
        u, v = np.rint(k.project(points)).T
        inside = (points[:, 2] > 0) & (u >= 0) & (v >= 0) & (u < columns) & (v < rows)
        visible &= inside
        u, v = np.where(inside, [u, v], 0).astype(int)
        depth = np.where(inside, image.depth[v, u], 0.0)
        readings = k.rays()[v, u] * depth[:, None]
        near = np.linalg.norm(readings @ axes.T - plan, axis=1) < MAX_OFFSET
        probed |= depth > 0
        rises |= (depth > 0) & near & (plane.height(readings) > MIN_RISE)
    return front.sum(), visible.sum(), probed.sum(), rises.sum()


@pytest.mark.parametrize("floor", [FLOOR, Plate((-5.0, 5.0), (-5.0, 5.0))])
def test_probes_equal_numpy(floor):
    frame, _ = solid_frame(walls(0.05)[:3], (floor, Plate(z=-0.4)))
    image = exact_image(frame)
    support = locate_support(PLANE, 0.8, image)
    assert support is not None
    hull = support.hull.astype(np.float64)
    edges = np.roll(hull, -1, axis=0) - hull
    normals = edges[:, ::-1] * [1.0, -1.0] / np.linalg.norm(edges, axis=1)[:, None]
    counts = np.arange(len(hull)) + 5
    axes = np.vstack([PLANE.normal, support.axes])
    found = probe_walls(hull, normals, counts, axes, PLANE.offset, image.depth, image.pinhole)
    assert found == probed_with_numpy(hull, normals, counts, PLANE, support.axes, image)
