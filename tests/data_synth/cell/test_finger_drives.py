"""Two fingers of a hand that close like two jaws."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from eyehand.data_synth.cell import make_robot
from eyehand.data_synth.cell.jaw_assembly import TOOL_FRAME
from eyehand.data_synth.cell.jaw_drives import FingerDrives
from eyehand.data_synth.cell.robot_names import FOLDER_VARIABLE
from eyehand.data_synth.mujoco_import import import_mujoco
from eyehand.errors import InputError
from eyehand.grasping import JawCommand
from eyehand.grasping.hands import HandCommand

ROBOTS = Path(__file__).resolve().parents[3].parent / "shared" / "robots"
pytestmark = pytest.mark.skipif(not ROBOTS.is_dir(), reason=f"no robot files in {ROBOTS}")
SECONDS = 1.5
BOX = 0.02
"""Half of the edge of the gripped box, m."""


@pytest.fixture(scope="module")
def gripped():
    """Return a model with the Allegro hand around a weightless box, and the robot."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv(FOLDER_VARIABLE, str(ROBOTS))
        robot = make_robot("panda", "allegro")
    mujoco = import_mujoco()
    spec = robot.spec(1.0)
    model = spec.compile()
    data = mujoco.MjData(model)
    _rest(data, robot)
    mujoco.mj_forward(model, data)
    tool = data.site(TOOL_FRAME)
    quaternion = np.zeros(4)
    mujoco.mju_mat2Quat(quaternion, tool.xmat)
    away = tool.xpos - 0.01 * tool.xmat.reshape(3, 3)[:, 2]
    box = spec.worldbody.add_body(name="box", pos=away, quat=quaternion, gravcomp=1.0)
    box.add_freejoint()
    box.add_geom(type=mujoco.mjtGeom.mjGEOM_BOX, size=[BOX] * 3, mass=0.1)
    spec.option.timestep = 0.002
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    return spec.compile(), robot


def _rest(data, robot):
    """Set arm and hand to rest."""
    for name, angle in zip(robot.joints, robot.home, strict=True):
        data.joint(name).qpos[0] = angle
    data.ctrl[: len(robot.home)] = robot.home
    for name, angle in zip(robot.hand_joints, robot.open_posture, strict=True):
        data.joint(name).qpos[0] = angle


def _run(gripped, command, seconds=SECONDS):
    """Return the data and the drives after a command."""
    mujoco = import_mujoco()
    model, robot = gripped
    data = mujoco.MjData(model)
    _rest(data, robot)
    drives = robot.create_drives(model, data, robot.hand_prefix)
    mujoco.mj_forward(model, data)
    drives.command(command)
    for _ in range(round(seconds / model.opt.timestep)):
        drives.apply()
        mujoco.mj_step(model, data)
    return data, drives


@pytest.mark.parametrize("force", [2.0, 6.0])
def test_fingertips_press_with_the_force_of_the_command(gripped, force):
    model, _ = gripped
    data, drives = _run(gripped, JawCommand(0.0, force))

    assert isinstance(drives, FingerDrives)
    assert drives.reading().width == pytest.approx(2 * BOX, abs=0.004)
    assert drives.reading().effort == pytest.approx(force, rel=0.01)
    box = model.body("box").id
    pressed: dict[str, float] = {}
    wrench = np.zeros(6)
    for number in range(data.ncon):
        bodies = model.geom_bodyid[data.contact.geom[number]]
        if box in bodies:
            import_mujoco().mj_contactForce(model, data, number, wrench)
            other = model.body(int(bodies[bodies != box][0])).name
            pressed[other] = pressed.get(other, 0.0) + float(wrench[0])
    assert set(pressed) == {"hand_mf_tip", "hand_th_tip"}
    assert list(pressed.values()) == pytest.approx([force, force], rel=0.3)


def test_fingers_follow_width_and_end_closed_without_effort(gripped):
    model, _ = gripped
    box = model.body("box").id
    geom = int(model.body_geomadr[box])
    model.geom_contype[geom] = model.geom_conaffinity[geom] = 0
    try:
        for width, reached in ((0.06, 0.06), (0.0, 0.0038)):
            _, drives = _run(gripped, JawCommand(width, 5.0))
            assert drives.reading().width == pytest.approx(reached, abs=1e-3)
            assert drives.reading().effort == pytest.approx(0.0, abs=0.1)
    finally:
        model.geom_contype[geom] = model.geom_conaffinity[geom] = 1


def test_command_of_fingers_is_refused(gripped):
    model, robot = gripped
    drives = robot.create_drives(model, import_mujoco().MjData(model), robot.hand_prefix)
    with pytest.raises(InputError, match="must be a finite JawCommand"):
        drives.command(HandCommand(("position",), np.zeros(1)))
