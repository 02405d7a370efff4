"""The grasp cell: placement of its parts, and invalid scenes."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import RigidTransform, Rotation

from eyehand.data_synth.cell import GraspCell, GraspRobot, GraspWorld, SimRobot, scene_options
from eyehand.data_synth.cell.grasp_cell import WORK_AREA_M
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


def test_whole_work_area_is_in_image():
    cell = GraspCell()
    x, y = 0.5 * np.array(WORK_AREA_M)
    corners = np.array(np.meshgrid([-x, x], [-y, y], [0.0, 0.25])).reshape(3, -1).T
    pixels = cell.intrinsics.project(cell.T_world_camera.inv().apply(corners))
    assert (pixels > 2).all()
    assert (pixels < np.array([637, 477])).all()


def test_tray_does_not_overlap_work_area():
    cell = GraspCell()
    left = cell.tray_centre[0] - cell.tray_size[0] / 2 - cell.tray_wall
    assert left > WORK_AREA_M[0] / 2 + 0.05


def test_friction_applies_to_all_pads():
    model = GraspWorld.build((), friction=0.6).model
    pads = [g for g in range(model.ngeom) if model.geom_priority[g] > 0]
    assert len(pads) > 10
    assert np.allclose(model.geom_friction[pads, 0], 0.6)
    assert np.isclose(GraspWorld.build(()).model.geom_friction[pads, 0].max(), 1.0)


def test_random_scene_is_built_in_cell():
    scene = make_scene(1, scene_options(count_range=(3, 3)))
    world = GraspWorld.build(scene.objects)
    assert world.object_names == tuple(item.name for item in scene.objects)
    assert world.model.opt.timestep == 0.002


def test_mesh_object_is_simulated():
    corners = 0.03 * np.array([[1, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1.0]])
    faces = np.array([[0, 1, 2], [0, 3, 1], [0, 2, 3], [1, 3, 2]])
    tilt = Rotation.from_rotvec([0.2, 0.1, 0.0])
    pose = RigidTransform.from_components([0.0, 0.1, 0.05], tilt)
    item = MeshObject("lump", corners, faces, 0.2, (0.5, 0.5, 0.5), pose)
    world = GraspWorld.build([item])
    robot = SimRobot(world)
    assert np.allclose(robot.object_pose("lump").translation, pose.translation)
    for _ in range(150):
        robot.step(np.zeros(7))
    # It fell onto a face. The centre of a tetrahedron is then at r / √3.
    resting = robot.object_pose("lump").translation[2]
    assert np.isclose(resting, 0.03 / np.sqrt(3), atol=2e-3)
    assert np.isclose(world.model.body("lump").mass[0], 0.2)


def test_build_rejects_invalid_scenes():
    objects = make_scene(1, scene_options(count_range=(1, 1))).objects
    with pytest.raises(InputError, match="twice"):
        GraspWorld.build([*objects, *objects])
    moved = objects[0].at(RigidTransform.from_translation(GraspCell().tray_centre))
    with pytest.raises(InputError, match="tray"):
        GraspWorld.build([moved])
    with pytest.raises(InputError, match="friction"):
        GraspWorld.build((), friction=0.0)


def test_build_with_robot_from_one_file(tmp_path: Path):
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
