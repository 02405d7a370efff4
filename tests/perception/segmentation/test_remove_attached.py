"""Tests of the parts of a robot, a person or a wall that the image cuts off."""

import numpy as np
import pytest
from random_planes import image_of

from eyehand.perception.segmentation import remove_attached as module
from eyehand.perception.segmentation.local_planes import LocalPlanes
from eyehand.perception.segmentation.remove_attached import remove_attached


@pytest.fixture(autouse=True)
def limits(monkeypatch):
    """Set the maximum size of a part, in an image far below the reference width."""
    monkeypatch.setattr(module, "MAX_SIZE", 20_000)


def scene():
    """Return the regions of a robot (1) at the border, its part (2), and an object (3) apart."""
    regions = np.zeros((80, 80), np.int32)
    regions[50:80, 10:70] = 1
    regions[42:50, 20:40] = 2
    regions[10:30, 20:40] = 3
    return regions


def remaining(regions, kept, depths=(3.0, 1.0, 1.0, 1.0, 1.0), bulge=0.0):
    """Return the numbers of the regions that stay, of those in `kept`.

    The sides of region 2 are farther than its middle by `bulge`, m.
    """
    numbers = np.zeros(6, np.int32)
    numbers[kept] = np.arange(1, len(kept) + 1)
    depth = np.array(depths)[regions]
    depth += np.where(regions == 2, bulge * ((np.arange(80) - 29.5) / 10) ** 2, 0.0)
    q = (1.0 / depth).astype(np.float32)
    flat = np.zeros_like(q)
    labels = remove_attached(
        numbers[regions], regions, image_of(q), LocalPlanes(q, flat, flat, flat)
    )
    found = {int(regions[labels == number][0]) for number in np.unique(labels[labels > 0])}
    assert labels.max(initial=0) == len(found)
    return found


def test_part_of_what_the_image_cuts_off_is_removed():
    assert remaining(scene(), [2, 3]) == {3}


def test_part_with_a_depth_step_all_along_stays():
    assert remaining(scene(), [2, 3], (3.0, 1.0, 0.8, 1.0)) == {2, 3}


@pytest.mark.parametrize(
    ("extent", "bulge", "left"), [(0.05, 0.0, {3}), (5.0, 0.0, {2, 3}), (0.05, 0.05, {2, 3})]
)
def test_large_region_is_removed_if_it_is_a_large_flat_face(monkeypatch, extent, bulge, left):
    monkeypatch.setattr(module, "MAX_SIZE", 100)
    monkeypatch.setattr(module, "MIN_EXTENT", extent)
    assert remaining(scene(), [2, 3], bulge=bulge) == left


@pytest.mark.parametrize(("length", "left"), [(1.0, {2, 3}), (0.1, {3})])
def test_large_part_that_the_image_cuts_off_too_is_removed(monkeypatch, length, left):
    monkeypatch.setattr(module, "MAX_SIZE", 100)
    monkeypatch.setattr(module, "MIN_CUT_LENGTH", length)
    regions = scene()
    regions[70:, :30] = 0
    regions[42:80, 20:30] = 2
    assert remaining(regions, [2, 3], bulge=0.05) == left


def test_part_of_a_region_inside_the_image_stays():
    regions = scene()
    regions[78:] = 0
    assert remaining(regions, [2, 3]) == {2, 3}


def test_part_that_touches_an_object_stays():
    regions = scene()
    regions[34:42, 20:40] = 4
    assert remaining(regions, [2, 3, 4]) == {2, 3, 4}


@pytest.mark.parametrize("kept", [[1, 2, 3], []])
def test_nothing_is_removed_without_surroundings(kept):
    assert remaining(scene(), kept) == set(kept)
