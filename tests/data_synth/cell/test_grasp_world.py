"""The cell: where everything stands, and what is refused."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import RigidTransform, Rotation

from eyehand.data_synth.cell import (
    WORK_AREA_M,
    GraspCell,
    GraspRobot,
    GraspWorld,
    SimRobot,
    scene_options,
)
from eyehand.data_synth.scenes import MeshObject, make_scene
from eyehand.errors import InputError

ARM_WITH_CLAW = """
<mujoco><worldbody><body name="foot"><geom size="0.05"/>
<body name="link" pos="0 0 0.2"><joint name="turn" axis="0 0 1" range="-2 2"/>
<geom type="capsule" size="0.03" fromto="0 0 0 0 0 0.3"/>
<body name="claw" pos="0 0 0.35"><geom size="0.02"/><site name="grip" pos="0 0 0.05"/>
</body></body></body></worldbody>
<actuator><position joint="turn" kp="100" kv="10"/></actuator></mujoco>
"""


def test_the_whole_work_area_is_in_the_picture():
    cell = GraspCell()
    x, y = 0.5 * np.array(WORK_AREA_M)
    corners = np.array(np.meshgrid([-x, x], [-y, y], [0.0, 0.25])).reshape(3, -1).T
    pixels = cell.intrinsics.project(cell.T_world_camera.inv().apply(corners))
    assert (pixels > 2).all()
    assert (pixels < np.array([637, 477])).all()


def test_tray_and_work_area_are_apart():
    cell = GraspCell()
    left = cell.tray_centre[0] - cell.tray_size[0] / 2 - cell.tray_wall
    assert left > WORK_AREA_M[0] / 2 + 0.05


def test_friction_is_the_whole_hands():
    model = GraspWorld.build((), friction=0.6).model
    pads = [g for g in range(model.ngeom) if model.geom_priority[g] > 0]
    assert len(pads) > 10
    assert np.allclose(model.geom_friction[pads, 0], 0.6)
    assert np.isclose(GraspWorld.build(()).model.geom_friction[pads, 0].max(), 1.0)


def test_a_drawn_scene_stands_in_the_cell():
    scene = make_scene(1, scene_options(count_range=(3, 3)))
    world = GraspWorld.build(scene.objects)
    assert world.object_names == tuple(item.name for item in scene.objects)
    assert world.model.opt.timestep == 0.002


def test_a_mesh_is_an_object_like_others():
    corners = 0.03 * np.array([[1, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1.0]])
    faces = np.array([[0, 1, 2], [0, 3, 1], [0, 2, 3], [1, 3, 2]])
    tilt = Rotation.from_rotvec([0.2, 0.1, 0.0])
    place = RigidTransform.from_components([0.0, 0.1, 0.05], tilt)
    item = MeshObject("lump", corners, faces, 0.2, (0.5, 0.5, 0.5), place)
    world = GraspWorld.build([item])
    robot = SimRobot(world)
    assert np.allclose(robot.object_pose("lump").translation, place.translation)
    for _ in range(150):
        robot.step(np.zeros(7))
    # It fell onto a face: the centre of a tetrahedron is a third as high as that.
    resting = robot.object_pose("lump").translation[2]
    assert np.isclose(resting, 0.03 / np.sqrt(3), atol=2e-3)
    assert np.isclose(world.model.body("lump").mass[0], 0.2)


def test_what_cannot_stand_together_is_refused():
    objects = make_scene(1, scene_options(count_range=(1, 1))).objects
    with pytest.raises(InputError, match="twice"):
        GraspWorld.build([*objects, *objects])
    moved = objects[0].at(RigidTransform.from_translation(GraspCell().tray_centre))
    with pytest.raises(InputError, match="tray"):
        GraspWorld.build([moved])
    with pytest.raises(InputError, match="friction"):
        GraspWorld.build((), friction=0.0)


def test_another_robot_in_one_file_can_be_put_there(tmp_path: Path):
    path = tmp_path / "claw.xml"
    path.write_text(ARM_WITH_CLAW)
    robot = GraspRobot(arm=path, hand=None, frame="grip", rest=None)
    world = GraspWorld.build((), robot=robot)
    assert robot.joints == ("turn",)
    assert robot.hand_joints == ()
    assert world.model.body("robot_claw").id > 0
    with pytest.raises(InputError, match="frame"):
        _ = GraspRobot(arm=path, hand=None, frame="nail").joints
    with pytest.raises(InputError, match="no such file"):
        GraspWorld.build((), robot=GraspRobot(arm=tmp_path / "none.xml"))
