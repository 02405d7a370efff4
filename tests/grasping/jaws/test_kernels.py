"""The compiled kernels equal their definition in NumPy."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from eyehand.grasping import load_hand
from eyehand.grasping.jaws.contact_kernels import contacts
from eyehand.grasping.jaws.kernels import BLOCKED, FAR, Limits, clearances, travels
from eyehand.grasping.jaws.point_blocks import point_blocks

RNG = np.random.default_rng(5)
HAND = load_hand("panda")
FINGER = np.array([[box.low, box.high] for box in HAND.finger_boxes])


def _candidates(count):
    rotation = np.ascontiguousarray(Rotation.random(count, rng=RNG).as_matrix())
    return rotation, RNG.uniform(-0.05, 0.05, (count, 3))


def _spheres(blocks):
    return blocks.blocks.start, blocks.blocks.centre, blocks.blocks.radius


@pytest.mark.parametrize("rank", [1, 3, 5])
@pytest.mark.parametrize(
    ("finger", "fixed"),
    [(FINGER, HAND.fixed_boxes()), (FINGER[:0], HAND.fixed_boxes()), (FINGER, FINGER[:0])],
    ids=["hand", "no finger", "no palm"],
)
def test_clearances(finger, fixed, rank):
    rotation, tip = _candidates(40)
    points = RNG.uniform(-0.15, 0.15, (300, 3))
    labels = RNG.integers(0, 3, 300)
    owner = RNG.integers(0, 3, 40)
    half = RNG.uniform(0.01, 0.04, 40)
    least = RNG.uniform(BLOCKED, 0.5 * FAR, 40)
    most = RNG.uniform(BLOCKED, FAR, (40, 2))
    most[::5, 0] = -np.inf
    blocks = point_blocks([points[labels == k] for k in range(3)], range(3))
    found = clearances(
        rotation,
        tip,
        half,
        owner,
        blocks.columns,
        blocks.label,
        finger,
        fixed,
        0.05,
        Limits(rank, least, most),
    )
    for i in range(40):
        local = (points - tip[i]) @ rotation[i]
        folded = local * [1, 1, 1]
        folded[:, 0] = np.abs(local[:, 0]) - half[i]
        distance = np.full(len(points), FAR)
        for where, boxes in ((folded, finger), (local, fixed)):
            for low, high in boxes:
                gap = np.maximum(low - [0, 0, 0.05] - where, where - high)
                outside = np.linalg.norm(np.maximum(gap, 0), axis=1)
                signed = np.where(gap.max(axis=1) <= 0, gap.max(axis=1), outside)
                distance = np.minimum(distance, signed)
        expected = [
            np.sort(np.append(distance[(labels == owner[i]) == own], [FAR] * 5))[rank - 1]
            for own in (True, False)
        ]
        expected = np.minimum(expected, most[i])
        sides = np.isfinite(most[i])
        assert np.all(np.isneginf(found[i, ~sides]))
        if expected[sides].min() < least[i]:
            # The kernel gives such a candidate up.
            assert expected[sides].min() - 1e-12 <= found[i, sides].min() < least[i]
        else:
            np.testing.assert_allclose(found[i, sides], expected[sides], atol=1e-12)


def test_far_points_and_none_give_the_largest_clearances():
    rotation, tip = _candidates(3)
    half, owner, most = np.full(3, 0.04), np.zeros(3, np.int64), np.full((3, 2), 0.01)
    for points in ([], [np.full((20, 3), 5.0)]):
        blocks = point_blocks(points, range(len(points)))
        boxes = FINGER, HAND.fixed_boxes()
        limits = Limits(3, np.full(3, BLOCKED), most)
        columns, label = blocks.columns, blocks.label
        found = clearances(rotation, tip, half, owner, columns, label, *boxes, 0.05, limits)
        np.testing.assert_array_equal(found, most)
        moved = travels(rotation, tip, half, columns, *boxes, 0.05, 0.001, 2)
        np.testing.assert_array_equal(moved, 0.05)


@pytest.mark.parametrize("rank", [1, 2])
def test_travels(rank):
    rotation, start = _candidates(40)
    points = RNG.uniform(-0.15, 0.15, (300, 3))
    half = RNG.uniform(0.01, 0.04, 40)
    blocks = point_blocks([points[points[:, 0] < 0], points[points[:, 0] >= 0]], [0, -1])
    found = travels(
        rotation,
        start,
        half,
        blocks.columns,
        FINGER,
        HAND.fixed_boxes(),
        0.05,
        0.001,
        rank,
    )
    for i in range(40):
        local = (points - start[i]) @ rotation[i]
        folded = local.copy()
        folded[:, 0] = np.abs(local[:, 0]) - half[i]
        until = np.full(len(points), 0.05)
        for where, boxes in ((folded, FINGER), (local, HAND.fixed_boxes())):
            for low, high in boxes:
                ahead = (where[:, :2] >= low[:2] + 0.001) & (where[:, :2] <= high[:2] - 0.001)
                met = ahead.all(axis=1) & (where[:, 2] >= low[2] + 0.001)
                until = np.where(met, np.minimum(until, where[:, 2] - high[2]), until)
        assert found[i] == pytest.approx(np.sort(until)[rank - 1], abs=1e-12)


def test_blocks_hold_every_point_once_with_its_label():
    groups = [RNG.uniform(-1, 1, (200, 3)), np.zeros((0, 3)), RNG.uniform(0, 0.05, (50, 3))]
    blocks = point_blocks(groups, [4, 7, -1])
    assert blocks.blocks.start[-1] == 250
    assert blocks.groups.start[-1] == len(blocks.blocks.radius)
    of_block = np.repeat(np.arange(len(blocks.label)), np.diff(blocks.groups.start))
    label = blocks.label[np.repeat(of_block, np.diff(blocks.blocks.start))]
    for number, value in ((0, 4), (2, -1)):
        np.testing.assert_array_equal(
            np.sort(blocks.points[label == value], axis=0), np.sort(groups[number], axis=0)
        )
    count = np.diff(blocks.blocks.start)
    for spheres, times in ((blocks.blocks, count), (blocks.groups, np.bincount(of_block, count))):
        centre = np.repeat(spheres.centre, times.astype(int), axis=0)
        radius = np.repeat(spheres.radius, times.astype(int))
        assert np.all(np.linalg.norm(blocks.points - centre, axis=1) <= radius + 1e-12)
    assert len(point_blocks([], []).label) == 0


@pytest.mark.parametrize("reach", [np.inf, 0.02])
def test_contacts_of_solid_points(reach):
    """Without measured points, the width is the extent of the points between the pads."""
    rotation, tip = _candidates(60)
    pad, reaches = (0.0085, 0.018, 0.004), np.full(60, reach)
    points = RNG.uniform(-0.04, 0.04, (500, 3))
    normals = points / np.linalg.norm(points, axis=1, keepdims=True)
    blocks = point_blocks([points], [0], 0.015)
    surface = (blocks.points, normals[blocks.order])
    found = contacts(rotation, tip, reaches, surface, _spheres(blocks), 0, pad, (0.6, 3))
    for i in range(60):
        local = (points - tip[i]) @ rotation[i]
        inside = (np.abs(local[:, 1]) <= 0.0085) & (local[:, 2] <= 0) & (local[:, 2] >= -0.018)
        inside &= np.abs(local[:, 0]) <= reach
        x, z = local[inside, 0], local[inside, 2]
        cosine = (normals @ rotation[i])[inside, 0]
        if inside.sum() < 2:
            assert found[i, 1] <= 0
            continue
        assert np.isclose(found[i, 1], np.ptp(x))
        assert np.isclose(found[i, 0], 0.5 * (x.max() + x.min()))
        right, left = x.max() - x < 0.004, x - x.min() < 0.004
        assert np.isclose(found[i, 2], cosine[right].max())
        assert np.isclose(found[i, 3], -cosine[left].min())
        assert np.isclose(found[i, 6], max(z[right].min(), z[left].min()))
        assert np.isclose(found[i, 7], min(z[right].max(), z[left].max()))


def test_seen_sides_are_counted():
    points = np.array([[0.02, y, -0.01] for y in np.linspace(-0.005, 0.005, 6)])
    normals = np.tile([1.0, 0.0, 0.0], (6, 1))
    solid = np.array([[0.022, 0.0, -0.01], [-0.02, 0.0, -0.01]])
    blocks = point_blocks([points, solid], [0, 1])
    directions = np.concatenate([normals, [[1.0, 0, 0], [-1.0, 0, 0]]])
    found = contacts(
        np.eye(3)[None],
        np.zeros((1, 3)),
        np.full(1, np.inf),
        (blocks.points, directions[blocks.order]),
        _spheres(blocks),
        6,
        (0.0085, 0.018, 0.004),
        (0.6, 3),
    )[0]
    assert found[4] == 1.0
    assert found[5] == 0.0
    # The solid lies beyond the readings, which prove a least width.
    assert np.isclose(found[1], 0.022 + 0.02)


@pytest.mark.parametrize("outer_seen", [False, True])
def test_inner_side_of_the_far_wall_is_no_face(outer_seen):
    """A cup of 80 mm, seen from the side: rim, inner walls, and one outer wall or none."""
    y = np.linspace(-0.005, 0.005, 6)
    rim = [[sign * 0.04, k, -0.001] for sign in (-1, 1) for k in y]
    inner = [[sign * 0.034, k, -0.01] for sign in (-1, 1) for k in y]
    outer = [[0.04, k, -0.01] for k in y if outer_seen]
    up, away = [[0.0, 0.0, -1.0]] * 12, [[1.0, 0.0, 0.0]] * 6
    towards = [[1.0, 0.0, 0.0]] * 6 + [[-1.0, 0.0, 0.0]] * 6
    points = np.array(rim + inner + outer)
    normals = np.array(up + towards + (away if outer_seen else []))
    solid = np.array([[0.041, 0.0, -0.01], [-0.041, 0.0, -0.01]])
    blocks = point_blocks([points, solid], [0, 1])
    directions = np.concatenate([normals, np.sign(solid) * [1, 0, 0]])
    found = contacts(
        np.eye(3)[None],
        np.zeros((1, 3)),
        np.full(1, np.inf),
        (blocks.points, directions[blocks.order]),
        _spheres(blocks),
        len(points),
        (0.0085, 0.018, 0.004),
        (0.6, 3),
    )[0]
    assert found[1] == pytest.approx(0.082)
    assert (found[4], found[5]) == (float(outer_seen), 0.0)
