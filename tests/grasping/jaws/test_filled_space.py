"""Fingers wholly inside a neighbour, which the points of its surface cannot show."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from jaw_scenes import EYE, bowl, box, can, scene_of
from scipy.spatial.transform import RigidTransform

from eyehand.grasping import load_hand, plan_grasps
from eyehand.grasping.jaws.filled_space import SPACING, filled_points
from eyehand.grasping.jaws.surface_model import object_surface
from eyehand.grasping.jaws.unseen import HiddenSpace

PANDA = load_hand("panda")
GAP, DEPTH, HEIGHT = 0.025, 0.05, 0.15
"""Gap to the object behind, its thickness along y and its height, m."""
FRONT = box((0.12, 0.03, HEIGHT))
PLACE = (0.0, 0.015 + GAP + 0.5 * DEPTH)
BEHIND = box((0.12, DEPTH, HEIGHT), PLACE, label=2)


def whole():
    return BEHIND


def floating():
    """Only the top of the object behind is seen, and the fit ends 0.05 m below it."""
    pose = RigidTransform.from_translation([*PLACE, HEIGHT - 0.025])
    solid = BEHIND.fit.superquadric
    assert solid is not None
    solid = replace(solid, semi_axes=np.array([0.06, 0.5 * DEPTH, 0.025]), pose=pose)
    top = BEHIND.points[BEHIND.points[:, 2] > HEIGHT - 1e-3]
    return replace(BEHIND, points=top, fit=replace(BEHIND.fit, superquadric=solid))


def depth_inside(grasp):
    """Return how deep the fingers of a grasp are in the true object behind, m."""
    shares = np.stack(np.meshgrid(*[np.linspace(0.05, 0.95, 12)] * 3), axis=-1).reshape(-1, 3)
    deepest = 0.0
    for side in (1.0, -1.0):
        for part in PANDA.finger_boxes:
            low, high = np.array(part.low), np.array(part.high)
            points = low + shares * (high - low)
            points[:, 0] = side * (points[:, 0] + 0.5 * grasp.width)
            local = grasp.T_scene_tcp.apply(points) - [*PLACE, 0.5 * HEIGHT]
            inside = 0.5 * np.array([0.12, DEPTH, HEIGHT]) - np.abs(local)
            deepest = max(deepest, float(inside.min(axis=1).max()))
    return deepest


@pytest.mark.parametrize("neighbour", [whole, floating])
def test_no_safe_grasp_has_a_finger_inside_the_object_behind(neighbour):
    grasps = [g for g in plan_grasps(scene_of(FRONT, neighbour()), PANDA) if g.object_label == 1]
    assert grasps
    for grasp in grasps:
        if grasp.safe:
            assert depth_inside(grasp) < 0.005, grasp.reason


def filled(*items):
    scene = scene_of(*items)
    surfaces = [object_surface(item, scene) for item in items]
    return filled_points(surfaces, scene, HiddenSpace(surfaces, EYE, PANDA))  # pyright: ignore[reportArgumentType]


def test_the_hidden_space_below_a_seen_top_is_filled_down_to_the_support():
    blocks = filled(FRONT, floating())
    second = int(blocks.groups.start[1])
    points = blocks.points[int(blocks.blocks.start[second]) :]
    assert blocks.label.tolist() == [0, 1]
    assert np.abs(points[:, 1] - PLACE[1]).max() < 0.5 * DEPTH + 1e-6
    assert points[:, 2].min() < SPACING
    below = points[points[:, 2] < 0.05]
    assert len(below) > 0.8 * (0.12 / SPACING) * (DEPTH / SPACING) * (0.05 / SPACING - 1)


def test_below_what_rests_on_another_object_nothing_is_filled():
    assert filled(FRONT, replace(floating(), rests_on=1)).label.tolist() == [0]


def test_the_inside_of_a_vessel_stays_free():
    blocks = filled(bowl(0.05, 0.06, 0.004), can(0.02, 0.05, (0.2, 0.0), label=2))
    middle = np.linalg.norm(blocks.points[:, :2], axis=1) < 0.03
    assert not (middle & (blocks.points[:, 2] > 0.03)).any()
