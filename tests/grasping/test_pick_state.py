"""What the phases of a pick share: the hand's true shape."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import RigidTransform

from eyehand.apps.grasp.ground_truth_scene import ground_truth_scene
from eyehand.data_synth.scenes import TabletopObject
from eyehand.grasping import GraspOptions, plan_grasps
from eyehand.grasping.cell import Cell
from eyehand.grasping.closing import preshape_command
from eyehand.grasping.pick_state import PickState, SelectedGrasp
from eyehand.grasping.tray import Tray
from eyehand.perception import Superquadric

from .fake_robot import HAND, FakeRobot

TRAY = Tray(np.array([0.0, -0.45, 0.006]), (0.25, 0.3), 0.05)
VIEW = np.array([0.0, 0.5, 0.9])


@pytest.fixture
def cell():
    return Cell(FakeRobot(), lambda _: ground_truth_scene([], VIEW), TRAY)


def job(prototype, size=(0.012, 0.02, 0.03)) -> PickState:
    """Plan a grasp of a box by a prototype."""
    pose = RigidTransform.from_translation([0.05, 0.0, size[2]])
    shape = Superquadric(np.array(sorted(size)), (0.1, 0.1), pose, "box")
    scene = ground_truth_scene([TabletopObject("box", shape, 0.1, (0.8, 0.2, 0.2))], VIEW)
    (item,) = scene.objects
    plans = plan_grasps(item, scene.support, hand=HAND, options=GraspOptions())
    plan = next(plan for plan in plans if plan.prototype == prototype)
    return PickState(SelectedGrasp(scene, item, plan), 0)


@pytest.mark.parametrize("prototype", ["pincer", "precision"])
def test_the_arm_keeps_off_with_the_hand_as_its_fingers_will_stand(cell, prototype):
    one = job(prototype)
    asked = preshape_command(HAND, one.plan.opening, prototype)
    stands, evenly = cell.model(asked.values), cell.model(HAND.excursions_at(one.plan.opening))
    assert one.model(cell) is stands
    assert (stands is evenly) == (prototype != "pincer"), "a pincer's idle fingers stand wider"
