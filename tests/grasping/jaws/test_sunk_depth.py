"""How deep a hand is sunk in surfaces, and safe grasps beside a flat top."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from jaw_scenes import box, scene_of
from scipy.spatial.transform import Rotation

from eyehand.grasping import JawOptions, load_hand, plan_grasps
from eyehand.grasping.jaws.candidates import Candidates
from eyehand.grasping.jaws.grasp import APPROACH
from eyehand.grasping.jaws.point_blocks import point_blocks
from eyehand.grasping.jaws.sunk_depth import NOISE_POINTS, NOISE_SHARE, sunk_depths
from eyehand.perception.object_evidence import SPACING

HANDS = [load_hand(name) for name in ("panda", "2f85", "wsg50")]
PANDA = HANDS[0]
OPENING = 0.06


def _candidates(tip, rotation):
    return Candidates(rotation, tip, np.zeros(len(tip), np.int64), np.full(len(tip), np.inf))


def _boxes(opening):
    boxes = np.concatenate([PANDA.jaw_boxes(opening), PANDA.fixed_boxes()])
    boxes[:, 0, 2] -= APPROACH
    return boxes


def _reference(points, tip, rotation, opening):
    """Return the depth of one hand in one group of points."""
    local, depth = (points - tip) @ rotation, 0.0
    for low, high in _boxes(opening):
        inside = local[np.all((local >= low) & (local <= high), axis=1)]
        rank = min(max(len(inside) // NOISE_SHARE, 1), NOISE_POINTS)
        if len(inside) > rank:
            out = np.column_stack([high - inside, inside[:, :2] - low[:2]])
            depth = max(depth, np.sort(out, axis=0)[-1 - rank].min())
    return depth


def test_depths_equal_their_definition():
    rng = np.random.default_rng(3)
    tip = rng.uniform(-0.05, 0.05, (40, 3))
    rotation = np.ascontiguousarray(Rotation.random(40, rng=rng).as_matrix())
    groups = [rng.uniform(-0.12, 0.12, (4000, 3)) for _ in range(2)]
    opening = rng.uniform(0.0, PANDA.stroke, 40)
    found = sunk_depths(_candidates(tip, rotation), opening, point_blocks(groups, [0, 1]), PANDA)
    expected = [
        [_reference(points, tip[i], rotation[i], opening[i]) for points in groups]
        for i in range(40)
    ]
    assert np.count_nonzero(found) > 40
    np.testing.assert_allclose(found, expected, atol=1e-12)


@pytest.mark.parametrize(("sunk", "expected"), [(0.02, True), (0.001, False), (-0.001, False)])
def test_finger_in_a_wide_surface_is_sunk_by_its_thickness_or_by_the_way_back(sunk, expected):
    grid = np.arange(-0.1, 0.1, SPACING)
    x, y = (part.ravel() for part in np.meshgrid(grid, grid))
    top = np.column_stack([x, y, np.full(len(x), -sunk)])
    blocks = point_blocks([top], [1])
    down = _candidates(np.zeros((1, 3)), np.eye(3)[None])
    ((own, others),) = sunk_depths(down, np.array([OPENING]), blocks, PANDA)
    low, high = PANDA.jaw_boxes(OPENING)[0]
    assert own == 0.0
    assert (others > 0.003) == expected
    assert others <= min(max(sunk, 0.0), high[0] - low[0]) + 1e-9


def test_single_readings_in_a_finger_are_noise():
    low, high = PANDA.jaw_boxes(OPENING)[0]
    blocks = point_blocks([0.5 * (low + high)[None]], [1])
    down = _candidates(np.zeros((1, 3)), np.eye(3)[None])
    np.testing.assert_array_equal(sunk_depths(down, np.array([OPENING]), blocks, PANDA), 0.0)


@pytest.mark.parametrize("hand", HANDS, ids=lambda hand: hand.name)
@pytest.mark.parametrize("gap", [0.0, 0.005, 0.012, 0.018])
def test_no_safe_finger_is_sunk_in_a_large_flat_neighbour(hand, gap):
    small, large = (0.04, 0.08, 0.05), (0.24, 0.28, 0.045)
    at = (0.5 * (small[0] + large[0]) + gap, 0.0)
    flat = box(large, at, label=2)
    grid = np.stack(np.meshgrid(*[np.arange(-0.5, 0.5, 0.01)] * 2), axis=-1).reshape(-1, 2)
    top = np.column_stack([grid * large[:2] + at, np.full(len(grid), large[2])])
    scene = scene_of(box(small), replace(flat, points=np.concatenate([flat.points, top])))
    options = JawOptions(depth_error=0.005, per_object=10)
    safe = [grasp for grasp in plan_grasps(scene, hand, options, [1]) if grasp.safe]
    assert safe
    for grasp in safe:
        boxes = hand.jaw_boxes(grasp.width)
        share = np.stack(np.meshgrid(*[np.linspace(0.0, 1.0, 9)] * 3), axis=-1).reshape(-1, 3)
        places = np.concatenate([low + share * (high - low) for low, high in boxes])
        local = np.abs(grasp.T_scene_tcp.apply(places) - [*at, 0.5 * large[2]])
        assert np.max(np.min(0.5 * np.array(large) - local, axis=1)) < 0.005
