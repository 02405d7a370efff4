"""Tests of the removal of small regions that are seen at a grazing angle."""

import numpy as np
import pytest
from random_planes import image_of

from eyehand.perception.segmentation import remove_steep as module
from eyehand.perception.segmentation.local_planes import LocalPlanes
from eyehand.perception.segmentation.remove_steep import count_nearer, count_steep, remove_steep
from eyehand.perception.segmentation.result import SupportPlane


@pytest.fixture(autouse=True)
def limits(monkeypatch):
    """Set the maximum size of a region, in an image far below the reference width."""
    monkeypatch.setattr(module, "MAX_AREA", 20_000)


def cosines(planes, pinhole):
    """Return the cosine of the angle between the view and the normal of each pixel, (H, W)."""
    fx, fy, cx, cy = pinhole
    v, u = np.indices(planes.value.shape)
    x, y = planes.slope_u * fx, planes.slope_v * fy
    z = planes.value - planes.slope_u * (u - cx) - planes.slope_v * (v - cy)
    ray = np.stack([(u - cx) / fx, (v - cy) / fy, np.ones(v.shape)])
    normal = np.stack([x, y, z])
    return (ray * normal).sum(axis=0) / np.linalg.norm(ray, axis=0) / np.linalg.norm(normal, axis=0)


def scene(slope):
    """Return regions 1 to 3, their image and planes; region 2 has this slope of disparity."""
    labels = np.zeros((60, 80), np.int32)
    labels[5:35, 5:45] = 1
    labels[40:50, 10:30] = 2
    labels[40:48, 50:60] = 3
    slope_u = np.where(labels == 2, slope, 0.0).astype(np.float32)
    q = (1.0 + slope_u * (np.arange(80) - 20)).astype(np.float32)
    return labels, image_of(q), LocalPlanes(q, slope_u, np.zeros_like(q), np.zeros_like(q))


@pytest.mark.parametrize("slope", [0.0, 0.01, 0.05])
def test_steep_pixels_are_counted_like_the_reference(slope):
    labels, image, planes = scene(slope)
    steep = cosines(planes, image.pinhole) < 0.25
    known, found = count_steep(labels, np.ones(4, bool), planes, image.pinhole, 0.25)
    np.testing.assert_array_equal(known, np.bincount(labels.ravel()))
    np.testing.assert_array_equal(found, np.bincount(labels.ravel(), weights=steep.ravel()))


@pytest.mark.parametrize(("slope", "kept"), [(0.0, 3), (0.002, 3), (0.1, 2)])
def test_small_region_at_a_grazing_angle_is_removed(slope, kept):
    labels, image, planes = scene(slope)
    unreliable = np.mean(cosines(planes, image.pinhole)[labels == 2] < 0.25)
    assert unreliable > 0.6 if kept == 2 else unreliable < 0.4
    left = remove_steep(labels, image, planes, None)[0]
    assert left.max() == kept
    assert (left[labels == 2] > 0).all() == (kept == 3)
    assert (left[labels == 3] == kept).all()


def test_large_region_stays(monkeypatch):
    monkeypatch.setattr(module, "MAX_AREA", 0)
    labels, image, planes = scene(0.05)
    assert remove_steep(labels, image, planes, None)[0] is labels


def test_pixels_without_a_plane_do_not_count():
    labels, image, planes = scene(0.0)
    none = np.zeros_like(planes.value)
    left = remove_steep(labels, image, planes._replace(value=none), None)[0]
    np.testing.assert_array_equal(left, labels)


def beside(nearer):
    """Return regions, image and planes; a third of region 2 is steep, and disparity beside it."""
    labels, _, planes = scene(0.0)
    slope_u = np.where((labels == 2) & (np.arange(80) >= 23), 0.1, 0.0).astype(np.float32)
    q = planes.value.copy()
    q[40:50, 30:40] = nearer
    return labels, image_of(q), planes._replace(slope_u=slope_u)


@pytest.mark.parametrize("reach", [1, 2])
def test_nearer_pixels_are_counted_like_the_reference(reach):
    labels, image, _ = beside(1.2)
    border, nearer = count_nearer(labels, np.ones(4, bool), image.disparity, 1.01, reach)
    # The right side of region 2 is 10 px high.
    assert nearer[1:].tolist() == [0, 10 * reach, 0]
    assert border[1:].tolist() == [2 * reach * n for n in (30 + 40, 10 + 20, 8 + 10)]


@pytest.mark.parametrize(("nearer", "kept"), [(1.2, 2), (1.0, 3), (0.8, 3), (0.0, 3)])
def test_ramp_beside_something_nearer_that_is_no_object_is_removed(nearer, kept):
    labels, image, planes = beside(nearer)
    assert remove_steep(labels, image, planes, None)[0].max() == kept


def test_steep_region_beside_a_nearer_object_stays():
    labels, image, planes = beside(1.2)
    labels[40:50, 30:40] = 3
    assert remove_steep(labels, image, planes, None)[0] is labels


@pytest.mark.parametrize(("share", "found"), [(0.9, 3), (0.2, 2)])
def test_steep_region_stays_if_most_of_its_readings_are_as_high_as_its_top(share, found):
    """The camera looks down; the rows below `share` of region 2 are ever farther from it."""
    labels, image, planes = scene(0.1)
    depth = np.where(labels == 2, 0.8, 1.0)
    rows = np.arange(60) - 40 - round(10 * share)
    depth[labels == 2] += np.repeat(0.015 * np.clip(rows[40:50], 0, None), 20)
    table = SupportPlane(np.array([0.0, 0.0, -1.0]), 1.0)
    image = image_of((1.0 / depth).astype(np.float32))
    left, lost = remove_steep(labels, image, planes, table)
    assert left.max() == found
    assert (lost == ((labels == 2) & (found == 2))).all()
