"""Objects of several parts: their other parts block the hand, rest on the table and have size."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import RigidTransform

from eyehand.grasping import select_prototype
from eyehand.grasping.hand_clearance import neighbour_points
from eyehand.grasping.hands import nominal_hand
from eyehand.grasping.pick_verification import have_same_size
from eyehand.perception import SceneObject, Superquadric, SupportPlane
from eyehand.perception.stacking import SurfaceBelow, rests_on

from .test_planning import TABLE, can


def with_part(item: SceneObject, part: Superquadric) -> SceneObject:
    solid = item.fit.superquadric
    assert solid is not None
    return replace(item, fit=replace(item.fit, parts=(solid, part)))


def solid_box(half, centre) -> Superquadric:
    pose = RigidTransform.from_translation(centre)
    return Superquadric(np.array(half), (0.1, 0.1), pose, "box")


def test_part_above_the_grasped_one_forbids_top_grasps():
    low_can = can(0.04, 0.08)
    assert select_prototype(low_can, TABLE).approach == "top"
    pole = solid_box((0.01, 0.01, 0.06), (0.0, 0.0, 0.14))
    plan = select_prototype(with_part(low_can, pole), TABLE)
    assert plan.approach != "top"
    assert any("another part" in reason for reason in plan.rejected.values())


def test_points_of_own_parts_carry_the_own_label_and_lie_beside_the_grasped_one():
    item = with_part(can(0.03, 0.16, label=7), solid_box((0.08, 0.01, 0.01), (0.0, 0.0, 0.1)))
    found = neighbour_points(item, (), nominal_hand())
    assert set(found.labels) == {7}
    solid = item.fit.superquadric
    assert solid is not None
    assert solid.distance(found.points).min() > 0.009


def test_mass_counts_all_parts():
    one = can(0.03, 0.16)
    two = with_part(one, solid_box((0.02, 0.02, 0.02), (0.0, 0.0, 0.0)))
    assert select_prototype(two, TABLE).mass[1] > select_prototype(one, TABLE).mass[1]


@pytest.mark.parametrize(("drop", "below"), [(0.0, None), (0.05, 0)])
def test_lowest_part_rests_on_the_table(drop, below):
    high = can(0.03, 0.1)
    solid = high.fit.superquadric
    assert solid is not None
    raised = replace(solid, pose=RigidTransform.from_translation([0.0, 0.0, 0.05]) * solid.pose)
    foot = solid_box((0.01, 0.01, 0.025), (0.0, 0.0, 0.075 - drop))
    fit = replace(high.fit, superquadric=raised, parts=(raised, foot))
    plane = SupportPlane(np.array([0.0, 0.0, 1.0]), 0.0)
    assert rests_on(np.full((1, 3), 0.1), fit, SurfaceBelow(0.0, 0), plane) == below


def testhave_same_size_compares_all_parts():
    one = can(0.03, 0.16)
    longer = with_part(one, solid_box((0.1, 0.01, 0.01), (0.0, 0.0, 0.1)))
    assert have_same_size(longer, longer)
    assert not have_same_size(longer, one)
