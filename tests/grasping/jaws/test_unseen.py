"""Space that other objects hide, and what forbids a grasp."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from jaw_scenes import EYE, box, can, scene_of

from eyehand.grasping import JawOptions, load_hand, plan_grasps
from eyehand.perception import SceneWarning
from eyehand.perception.superquadric import SuperquadricFit

PANDA = load_hand("panda")


def _hidden(*items):
    scene = scene_of(*items)
    return plan_grasps(scene, PANDA)


def test_object_behind_a_wall_is_gripped_in_hidden_space_and_not_safely():
    wall = box((0.20, 0.02, 0.16), (0.0, -0.06), label=2)
    alone = _hidden(can(0.02, 0.06))
    behind = _hidden(can(0.02, 0.06), wall)
    first = next(grasp for grasp in alone if grasp.object_label == 1)
    later = next(grasp for grasp in behind if grasp.object_label == 1)
    assert first.safe
    assert first.terms["unseen"] == 1.0
    assert later.terms["unseen"] < 0.9
    assert not later.safe
    assert any("hides" in text for text in later.forbidden_by)


def test_own_object_hides_nothing():
    scene = scene_of(can(0.03, 0.1))
    grasps = plan_grasps(scene, PANDA)
    assert all(grasp.terms["unseen"] == 1.0 for grasp in grasps)


def test_object_in_front_does_not_count():
    near = can(0.02, 0.06, (0.0, float(EYE[1]) / 3), label=2)
    grasps = _hidden(near, box((0.03, 0.03, 0.1), (0.15, 0.0)))
    assert all(g.terms["unseen"] == 1.0 for g in grasps if g.object_label == 1)


def test_heavy_and_unsupported_objects_are_not_safe():
    large = scene_of(box((0.07, 0.4, 0.4)))
    grasps = plan_grasps(large, PANDA)
    assert all(any("may weigh" in text for text in grasp.forbidden_by) for grasp in grasps)
    loose = replace(large, support=None, objects=(box((0.05, 0.05, 0.05)),))
    assert all("no support was found" in g.forbidden_by for g in plan_grasps(loose, PANDA))


def test_rejected_solid_is_grasped_with_less_confidence():
    """Such a solid covers space that the view shows to be empty, but is mostly right."""
    scene = scene_of(box((0.04, 0.05, 0.08)))
    item = scene.objects[0]
    fit = replace(item.fit, converged=False, reason="20 % of the solid lies in empty space")
    doubtful = plan_grasps(replace(scene, objects=(replace(item, fit=fit),)), PANDA)
    certain = plan_grasps(scene, PANDA)
    assert doubtful[0].safe
    assert doubtful[0].success < certain[0].success
    assert doubtful[0].object_width == pytest.approx(certain[0].object_width)


def test_rejected_solid_is_not_grasped_where_nothing_was_seen():
    """The solid bridges the gap between two posts."""
    scene = scene_of(box((0.15, 0.05, 0.08)))
    item = scene.objects[0]
    fit = replace(item.fit, converged=False, reason="20 % of the solid lies in empty space")
    posts = item.points[np.abs(item.points[:, 0]) > 0.05]
    bridge = replace(scene, objects=(replace(item, fit=fit, points=posts),))
    grasps = plan_grasps(bridge, PANDA, JawOptions(per_object=100))
    assert grasps[0].safe
    assert abs(grasps[0].position[0]) > 0.04
    in_gap = [one for one in grasps if abs(one.position[0]) < 0.03 and abs(one.closing[1]) > 0.9]
    assert in_gap
    assert all("the object was not seen between the pads" in one.forbidden_by for one in in_gap)
    assert max(one.success for one in in_gap) < 0.3


def test_object_without_any_solid_is_not_safe():
    scene = scene_of(box((0.04, 0.05, 0.08)))
    item = replace(scene.objects[0], fit=SuperquadricFit.rejected("too little was seen"))
    grasps = plan_grasps(replace(scene, objects=(item,)), PANDA)
    assert grasps
    assert all("no solid was fitted" in one.forbidden_by for one in grasps)


def test_object_that_may_be_several_is_named_so():
    scene = scene_of(can(0.02, 0.06), can(0.02, 0.06, (0.2, 0.0), label=2))
    warning = SceneWarning("may_be_several", "object 2 may be more than one", 2)
    segmentation = replace(scene.segmentation, warnings=(warning,))
    grasps = plan_grasps(replace(scene, segmentation=segmentation), PANDA)
    named = {grasp.object_label: "more or less than one" in grasp.reason for grasp in grasps}
    assert named == {1: False, 2: True}


def test_object_cut_by_the_image_is_not_safe():
    scene = scene_of(can(0.02, 0.06), can(0.02, 0.06, (0.2, 0.0), label=2))
    warning = SceneWarning("cut_by_image", "object 2 is cut off", 2)
    segmentation = replace(scene.segmentation, warnings=(warning,))
    grasps = plan_grasps(replace(scene, segmentation=segmentation), PANDA)
    assert {grasp.object_label for grasp in grasps} == {1, 2}
    assert any(grasp.safe for grasp in grasps if grasp.object_label == 1)
    assert all("border" in " ".join(g.forbidden_by) for g in grasps if g.object_label == 2)


@pytest.mark.parametrize(
    ("kind", "words"),
    [("camera", "intrinsics"), ("pose", "pose of the camera"), ("support_tilted", "tilted")],
)
def test_no_grasp_is_safe_in_a_scene_whose_positions_are_probably_wrong(kind, words):
    scene = scene_of(can(0.02, 0.06))
    segmentation = replace(scene.segmentation, warnings=(SceneWarning(kind, "wrong"),))
    wrong = replace(scene, segmentation=segmentation)
    assert all(words in " ".join(grasp.forbidden_by) for grasp in plan_grasps(wrong, PANDA))
    inclined = plan_grasps(wrong, PANDA, JawOptions(inclined=True))
    assert bool(inclined.grasps[0].safe) == (kind == "support_tilted")
