"""Tests of cutting patches at necks: the watershed equals a plain one, solids stay whole."""

import numpy as np
import pytest
from synthetic_solids import Ball, Box, exact_image, solid_frame

from eyehand.perception.segmentation.cut_necks import (
    LEVELS,
    MIN_HALF_WIDTH,
    NECK,
    cut_necks,
    separate_parts,
)


def reference(patches, distance, min_peak, neck):
    """Separate the parts with sets of pixels, visited in the same order; return a list of sets."""
    columns = patches.shape[1]
    order = sorted(np.flatnonzero(patches), key=lambda k: -int(distance.flat[k] * LEVELS))
    part_of, parts = {}, []
    for k in order:
        v, u = divmod(int(k), columns)
        own = None
        for y, x in ((v - 1, u), (v + 1, u), (v, u - 1), (v, u + 1)):
            near = part_of.get((y, x))
            if near is None or patches[y, x] != patches[v, u] or near is own:
                continue
            if own is None:
                own = near
                continue
            broad, narrow = (own, near) if own["peak"] >= near["peak"] else (near, own)
            if narrow["peak"] < min_peak or distance[v, u] >= neck * narrow["peak"]:
                broad["pixels"] |= narrow["pixels"]
                part_of.update(dict.fromkeys(narrow["pixels"], broad))
                parts.remove(narrow)
            own = broad
        if own is None:
            own = {"peak": distance[v, u], "pixels": set()}
            parts.append(own)
        own["pixels"].add((v, u))
        part_of[v, u] = own
    return [part["pixels"] for part in parts]


@pytest.mark.parametrize("seed", range(4))
def test_watershed_equals_reference(seed):
    rng = np.random.default_rng(seed)
    patches = np.ones((14, 18), np.int32)
    patches[:, 11] = 0
    patches[:, 12:] = 2
    # Few levels far apart, so that both orders agree up to ties.
    distance = rng.permutation(patches.size).reshape(patches.shape).astype(np.float32)
    distance[patches == 0] = 0.0
    several = np.array([False, True, True])
    labels, owner = separate_parts(patches, several, distance, 100.0, 0.6)
    expected = reference(patches, distance, 100.0, 0.6)
    found = [set(map(tuple, np.argwhere(labels == k))) for k in range(1, len(owner))]
    assert len(found) > 2
    assert sorted(map(sorted, found)) == sorted(map(sorted, expected))
    for part in range(1, len(owner)):
        assert set(patches[labels == part]) == {owner[part]}


def scene(solids):
    """Return the image of solids, and one patch of all their pixels."""
    frame, labels = solid_frame(solids)
    return exact_image(frame), (labels > 0).astype(np.int32), labels


def test_two_boxes_that_touch_at_a_corner_are_cut():
    image, patches, labels = scene(
        [Box(-0.09, 0.65, (0.14, 0.14, 0.1)), Box(0.09, 0.78, (0.18, 0.16, 0.1))]
    )
    bridge = np.zeros(patches.shape, np.int32)
    rows, columns = np.nonzero(labels == 2)
    first = int(np.argmin(columns))
    bridge[rows[first] - 1 : rows[first] + 2, columns[first] - 12 : columns[first] + 1] = 1
    joined = patches | bridge
    parts = cut_necks(joined, image)
    assert np.array_equal(parts > 0, joined > 0)
    first, second = (np.unique(parts[labels == k], return_counts=True) for k in (1, 2))
    main = [int(found[np.argmax(counts)]) for found, counts in (first, second)]
    assert main[0] != main[1]


@pytest.mark.parametrize(
    "solid",
    [Ball(0.0, 0.65, 0.1, 0.1), Box(0.0, 0.65, (0.3, 0.1, 0.1)), Box(0.0, 0.65, (0.1, 0.2, 0.02))],
)
def test_convex_solid_is_not_cut(solid):
    image, patches, _ = scene([solid])
    assert np.array_equal(cut_necks(patches, image), patches)


def test_narrow_part_in_front_of_its_own_surface_is_not_cut():
    # A flat surface in the shape of a dumb-bell: no line crosses free space.
    image, patches, _ = scene([Box(0.0, 0.65, (0.3, 0.2, 0.02))])
    rows, columns = np.nonzero(patches)
    middle = (columns.min() + columns.max()) // 2
    top = (rows.min() + rows.max()) // 2
    bell = patches.copy()
    bell[: top - 1, middle - 2 : middle + 3] = 0
    bell[top + 2 :, middle - 2 : middle + 3] = 0
    assert NECK * MIN_HALF_WIDTH > 1
    assert np.array_equal(cut_necks(bell, image), bell)
