"""Tests of joining patches: contraction equals a plain reference, solids stay whole and apart."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from synthetic_solids import Ball, Box, exact_image, heights, solid_frame

from eyehand.perception import SegmentationOptions
from eyehand.perception.segmentation import join_patches as module
from eyehand.perception.segmentation.ambiguity import NEARLY
from eyehand.perception.segmentation.join_patches import (
    COLOUR_GAIN,
    EQUAL_HIDDEN_GAIN,
    MIN_CONTACT,
    UNLIKE_GAIN,
    contract_edges,
    edge_weights,
    find_slivers,
    have_contact,
    join_patches,
)
from eyehand.perception.segmentation.local_planes import fit_local_planes
from eyehand.perception.segmentation.patch_edges import PatchEdges

OPTIONS = SegmentationOptions().scaled(320)


def reference(pairs, weights, count):
    """Contract the largest positive weight of the full matrix until none is left."""
    table = np.zeros((count + 1, count + 1))
    for (a, b), weight in zip(pairs, weights, strict=True):
        table[a, b] = table[b, a] = weight
    parent = np.arange(count + 1)
    while table.max() > 0:
        a, b = sorted(np.unravel_index(np.argmax(table), table.shape))
        table[a] += table[b]
        table[:, a] = table[a]
        table[b] = table[:, b] = table[a, a] = 0.0
        parent[parent == b] = a
    return parent


@given(seed=st.integers(0, 10_000), count=st.integers(2, 12))
@settings(max_examples=40)
def test_contraction_equals_reference(seed, count):
    rng = np.random.default_rng(seed)
    pairs = np.array([(a, b) for a in range(1, count + 1) for b in range(a + 1, count + 1)])
    pairs = pairs[rng.random(len(pairs)) < 0.6].reshape(-1, 2)
    weights = rng.normal(size=len(pairs))
    assert np.array_equal(contract_edges(pairs, weights, count), reference(pairs, weights, count))


@pytest.mark.parametrize(
    ("joined", "factor", "expected"), [(3, 0.8, True), (3, 0.6, False), (1, 0.8, False)]
)
def test_contact_between_objects_is_summed_over_their_patches(joined, factor, expected):
    edges = PatchEdges(np.array([[1, 2], [1, 3]]), *np.zeros((7, 2)))
    edges = edges._replace(contact=np.full(2, factor * MIN_CONTACT))
    # Patches 2 and 3 are one object, or all three are.
    parent = np.array([0, 1, 1 if joined == 1 else 2, 1 if joined == 1 else 2])
    assert have_contact(edges, parent) == expected


def test_sliver_is_narrow_or_tiny():
    frame, _ = solid_frame([])
    patches = np.zeros(frame.depth.shape, np.int32)
    patches[20:60, 20:60], patches[100:102, 20:90], patches[150:154, 20:25] = 1, 2, 3
    assert find_slivers(patches, exact_image(frame)).tolist() == [False, False, True, True]


def test_sliver_between_two_boxes_does_not_join_them():
    boxes = [Box(-0.08, 0.65, (0.1, 0.1, 0.1)), Box(0.08, 0.65, (0.1, 0.1, 0.1))]

    def with_sliver(labels, points):
        patches = labels.copy()
        middle = np.abs(points[..., 0]) < 0.032
        patches[middle & (labels > 0)] = 3
        return patches

    left, right, _ = join(boxes, with_sliver)
    assert not left & right


def join(solids, split=lambda labels, points: labels, paint=None):
    """Return the set of objects that each patch becomes.

    `split` cuts exact solids to patches. `paint` lists the colours of the patches, RGB.
    """
    frame, labels = solid_frame(solids)
    height = heights(frame)
    patches = split(labels, np.dstack([frame.points()[..., 0], height])).astype(np.int32)
    image = exact_image(frame)
    if paint is not None:
        image = image._replace(colour=np.array([(0, 0, 0), *paint], np.uint8)[patches])
    planes = fit_local_planes(image, OPTIONS)
    objects, _ = join_patches(patches, image, planes, OPTIONS.window, OPTIONS.min_object)
    assert np.array_equal(objects > 0, patches > 0)
    return [set(np.unique(objects[patches == k])) for k in range(1, patches.max() + 1)]


@pytest.mark.parametrize("yaw", [0.0, 0.3, 0.7])
def test_box_faces_are_one_object(yaw):
    box = Box(0.0, 0.65, (0.15, 0.15, 0.12), yaw=yaw)
    faces = join([box], lambda labels, at: labels * (1 + (at[..., 1] > 0.119)))
    assert len(faces) == 2
    assert faces[0] == faces[1]


RED, BLUE = (200, 30, 30), (30, 30, 200)


@pytest.mark.parametrize("other", [RED, BLUE])
def test_faces_of_any_colour_are_one_object(other):
    box = Box(0.0, 0.65, (0.15, 0.15, 0.12), yaw=0.3)
    faces = join([box], lambda labels, at: labels * (1 + (at[..., 1] > 0.119)), [RED, other])
    assert faces[0] == faces[1]


@pytest.mark.parametrize("other", [RED, BLUE])
def test_parts_of_any_colour_behind_an_occluder_are_one_object(other):
    post = Box(0.0, 0.5, (0.04, 0.04, 0.3))
    behind = Box(0.0, 0.75, (0.3, 0.1, 0.1))

    def halves(labels, points):
        patches = labels.copy()
        patches[(labels == 2) & (points[..., 0] > 0)] = 3
        return patches

    _, left, right = join([post, behind], halves, [(20, 180, 20), RED, other])
    assert left == right


@pytest.mark.parametrize(
    ("contact", "unlike", "equal"),
    [(0.0, 0.0, EQUAL_HIDDEN_GAIN), (1.0, UNLIKE_GAIN, COLOUR_GAIN)],
)
def test_different_colours_count_only_between_touching_patches(contact, unlike, equal):
    pairs = np.array([[1, 2], [1, 3], [2, 3]])
    edges = PatchEdges(pairs, *np.zeros((7, 3)))._replace(contact=np.full(3, contact))
    without = edge_weights(edges)
    added = edge_weights(edges._replace(colour=np.array([-0.5, 0.0, 0.5]))) - without
    assert added == pytest.approx([-0.5 * unlike, 0.0, 0.5 * equal])


def test_ball_halves_are_one_object():
    ball = Ball(0.0, 0.65, 0.1, 0.1)
    left, right = join([ball], lambda labels, at: labels * (1 + (at[..., 0] > 0.02)))
    assert left == right


@pytest.mark.parametrize(
    "solids",
    [
        # A concave border; free space between the solids; a depth step.
        [Box(0.0, 0.8, (0.3, 0.05, 0.2)), Box(0.0, 0.7, (0.3, 0.15, 0.05))],
        [Ball(-0.06, 0.65, 0.06, 0.06), Ball(0.06, 0.65, 0.06, 0.06)],
        [Box(0.0, 0.6, (0.1, 0.1, 0.15)), Box(0.05, 0.9, (0.2, 0.1, 0.2))],
    ],
)
def test_two_solids_stay_separate(solids):
    first, second_object = join(solids)
    assert not first & second_object


@pytest.mark.parametrize(("least", "reported"), [(-100.0, True), (100.0, False)])
def test_solids_that_are_nearly_joined_are_reported(monkeypatch, least, reported):
    monkeypatch.setattr(module, "NEARLY_JOINED", least)
    frame, patches = solid_frame(
        [Box(0.0, 0.8, (0.3, 0.05, 0.2)), Box(0.0, 0.7, (0.3, 0.15, 0.05))]
    )
    image = exact_image(frame)
    planes = fit_local_planes(image, OPTIONS)
    labels, uncertain = join_patches(patches, image, planes, OPTIONS.window, OPTIONS.min_object)
    flat = labels.ravel()
    near = [one for one in uncertain if one.reason == NEARLY]
    assert [flat[one.pixel_a] != flat[one.pixel_b] for one in near] == [True] * reported


def test_fewer_than_two_patches_stay_unchanged():
    frame, labels = solid_frame([Ball(0.0, 0.65, 0.1, 0.1)])
    image = exact_image(frame)
    planes = fit_local_planes(image, OPTIONS)
    for patches in (labels, np.zeros_like(labels)):
        objects, _ = join_patches(patches, image, planes, OPTIONS.window, OPTIONS.min_object)
        assert np.array_equal(objects, patches)
