"""Memory of failed grasps: objects that moved or turned are recognised, others come first."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.spatial.transform import RigidTransform, Rotation

from eyehand.apps.grasp.ground_truth_scene import ground_truth_scene
from eyehand.data_synth.scenes import TabletopObject
from eyehand.grasping.failed_grasps import FailedGrasps
from eyehand.grasping.planning import plan_prototypes
from eyehand.perception import Superquadric

VIEW = np.array([0.0, 0.5, 0.9])


def box(x, turn=0.0, size=(0.04, 0.07, 0.09)):
    """Return a box on the table at x, turned about the vertical."""
    half = 0.5 * np.array(size)
    pose = RigidTransform.from_components([x, 0.0, half[2]], Rotation.from_rotvec([0, 0, turn]))
    shape = Superquadric(half, (0.1, 0.1), pose, "box")
    return TabletopObject(f"box_{x}", shape, 0.1, (0.8, 0.2, 0.2))


def scene_of(*boxes):
    return ground_truth_scene(boxes, VIEW)


def width(plan):
    """Return the width of the object along the closing direction, m."""
    assert plan.geometry is not None
    return plan.geometry.width


def remembered(scene):
    """Return a memory in which the best grasp of the first object failed, and that plan."""
    memory = FailedGrasps()
    plan = plan_prototypes(scene.objects[0], scene.support)[0]
    memory.add(scene, scene.objects[0], plan)
    return memory, plan


def test_object_that_was_kicked_and_turned_is_recognised_with_its_grasp():
    memory, plan = remembered(scene_of(box(0.0), box(0.3)))
    after = scene_of(box(0.08, turn=0.9), box(0.3))
    found = memory.recognise(after)
    assert set(found) == {1}
    entry = found[1]
    same = [p for p in plan_prototypes(after.objects[0], after.support) if p.name == plan.name]
    repeats = [p for p in same if abs(width(p) - width(plan)) < 0.002]
    assert repeats
    assert all(entry.repeats(p, after.objects[0]) for p in repeats)
    others = [p for p in same if abs(width(p) - width(plan)) > 0.01]
    assert not any(entry.repeats(p, after.objects[0]) for p in others)


def test_object_of_another_size_or_too_far_is_new():
    memory, _ = remembered(scene_of(box(0.0)))
    assert not memory.recognise(scene_of(box(0.08, size=(0.06, 0.07, 0.09))))
    assert not memory.recognise(scene_of(box(0.25)))


def test_neighbour_of_the_same_size_is_not_taken_for_the_failed_object():
    memory, _ = remembered(scene_of(box(0.0), box(0.1)))
    assert memory.recognise(scene_of(box(0.1))) == {}


def test_failures_of_one_object_add_up_while_it_moves():
    first, second = scene_of(box(0.0)), scene_of(box(0.06))
    memory, plan = remembered(first)
    memory.add(second, second.objects[0], plan, slipped=True)
    third = memory.recognise(scene_of(box(0.12)))
    assert len(third[1].grasps) == 2
    assert third[1].slipped


def test_part_of_a_failed_object_that_is_segmented_anew_is_recognised():
    memory, _ = remembered(scene_of(box(0.0, size=(0.04, 0.12, 0.09))))
    whole = scene_of(box(0.0, size=(0.04, 0.12, 0.09))).objects[0]
    points = whole.points[whole.points[:, 1] > 0.01]
    assert np.linalg.norm(points.mean(axis=0) - whole.points.mean(axis=0)) > 0.03
    part = replace(whole, label=1, points=points)
    assert 1 in memory.recognise(replace(scene_of(), objects=(part,)))
