"""Grasps of fingers against a thumb from the contacts of jaws."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from jaw_scenes import box, scene_of

from eyehand.control.tasks import Position
from eyehand.grasping import GraspPlan
from eyehand.grasping.control_tasks import control_tasks
from eyehand.grasping.hand_clearance import hand_boxes
from eyehand.grasping.hands import nominal_hand
from eyehand.grasping.opposed_grasps import TABLE_GAP, finger_jaws, plan_opposed_grasps
from eyehand.perception import Scene, SuperquadricFit

HAND = nominal_hand()


def unfitted(scene: Scene) -> Scene:
    """Return a scene whose objects have no solid."""
    fit = SuperquadricFit.rejected("bent")
    return replace(scene, objects=tuple(replace(item, fit=fit) for item in scene.objects))


def best(scene: Scene, label: int = 1) -> GraspPlan:
    plans = [plan for _, plan in plan_opposed_grasps(scene, HAND, {label})]
    return max(plans, key=lambda plan: plan.score.total)


def palm_of(plan: GraspPlan) -> np.ndarray:
    position = control_tasks(plan, HAND)[0]
    assert isinstance(position, Position)
    return position.goal


def test_object_without_solid_is_held_across_its_narrow_side():
    plan = best(unfitted(scene_of(box((0.10, 0.04, 0.06), turn=0.4))))
    narrow = np.array([-np.sin(0.4), np.cos(0.4), 0.0])
    assert abs(plan.closing @ narrow) > 0.95
    assert plan.prototype == "precision"
    assert plan.gripped_width == pytest.approx(0.04, abs=0.005)
    assert plan.opening > 0.04
    assert plan.mass[1] == pytest.approx(600 * 0.10 * 0.04 * 0.06, rel=0.2)
    assert np.prod(list(plan.score.terms.values())) == pytest.approx(plan.score.total)


def test_hand_stays_above_the_support_and_retreats_along_the_palm():
    plan = best(scene_of(box((0.05, 0.05, 0.02))))
    palm = palm_of(plan)
    assert plan.geometry is not None
    assert plan.gripped_width is not None
    axes = np.array([plan.closing, plan.geometry.finger_row, plan.palm])
    for low, high in hand_boxes(HAND, "precision", plan.opening, plan.gripped_width):
        corners = np.stack(np.meshgrid(*np.stack([low, high], 1)), -1).reshape(-1, 3)
        assert ((corners @ axes + palm)[:, 2] > TABLE_GAP - 1e-6).all()
    back = control_tasks(plan, HAND, 0.1)[0]
    assert isinstance(back, Position)
    assert back.goal == pytest.approx(palm - 0.1 * plan.palm)


def test_only_wanted_objects_are_planned_and_neighbours_count():
    size = (0.05, 0.05, 0.05)
    apart = scene_of(box(size), box(size, (0.3, 0.0), label=2))
    assert {item.label for item, _ in plan_opposed_grasps(apart, HAND, {2})} == {2}
    beside = [box(size, (0.055 * x, 0.0), label=3 + x) for x in (-1, 1)]
    free = best(scene_of(box(size), *beside))
    # Only the sides without a neighbour leave room.
    assert abs(free.closing @ [0.0, 1.0, 0.0]) > 0.95
    around = [box(size, (0.0, 0.055 * y), label=6 + y) for y in (-1, 1)]
    scene = scene_of(box(size), *beside, *around)
    crowded = [plan for _, plan in plan_opposed_grasps(scene, HAND, {1})]
    assert all(plan.score.total < 0.2 * free.score.total for plan in crowded)


def test_jaws_of_a_hand_have_its_opening_and_pads():
    jaws = finger_jaws(HAND)
    assert jaws.stroke < HAND.max_opening
    assert jaws.pad_width == HAND.finger_width
    assert max(box.high[2] for box in jaws.palm_boxes) == pytest.approx(-HAND.reaches.max())
