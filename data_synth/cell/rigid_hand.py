"""An arm with its hand, open and rigid, as one MJCF file."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

from scipy.spatial.transform import RigidTransform, Rotation

from ..arms import HOME_KEY
from ..mujoco_import import import_mujoco

if TYPE_CHECKING:
    from .grasp_robot import GraspRobot


def write_rigid_hand(robot: GraspRobot, file: Path) -> None:
    """Write a robot whose hand is open, and whose only joints are those of the arm.

    Parameters
    ----------
    robot
        Arm and hand.
    file
        MJCF file to write. It names the mesh files of arm and hand by absolute paths. Its keyframe
        ``home`` is the rest posture.

    Raises
    ------
    InputError
        If MuJoCo cannot compile the robot.
    """
    spec = robot.description(robot.home, robot.open_drives, RigidTransform.identity())
    _fix_joints(spec, keep=robot.joints)
    spec.add_key(name=HOME_KEY, qpos=robot.home)
    for material in spec.materials:
        material.textures = [""] * len(material.textures)
    for texture in list(spec.textures):
        spec.delete(texture)
    used = {geom.meshname for geom in spec.geoms}
    for mesh in list(spec.meshes):
        if mesh.name not in used:
            spec.delete(mesh)
        elif mesh.file:
            part = robot.hand if mesh.name.startswith(robot.hand_prefix or "\0") else robot.arm
            folder = Path(part or robot.arm).resolve().parent
            mesh.file = str(folder / mesh.compiler.meshdir / mesh.file)
    spec.compile()
    file.write_text(spec.to_xml(), encoding="utf-8")


def _fix_joints(spec: Any, keep: tuple[str, ...]) -> None:
    """Weld all joints of a spec but those to keep, in its first keyframe, and delete its drives."""
    mujoco = import_mujoco()
    model = spec.compile()
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, 0)
    mujoco.mj_kinematics(model, data)
    for kind in ("keys", "sensors", "actuators", "tendons", "equalities"):
        for one in list(getattr(spec, kind)):
            spec.delete(one)
    for body in spec.bodies[1:]:
        fixed = [joint for joint in body.joints if joint.name not in keep]
        if not fixed:
            continue
        here, parent = model.body(body.name).id, model.body(body.parent.name).id
        turns = Rotation.from_matrix(data.xmat[[parent, here]].reshape(2, 3, 3))
        body.pos = turns[0].inv().apply(data.xpos[here] - data.xpos[parent])
        body.quat = (turns[0].inv() * turns[1]).as_quat(scalar_first=True)
        body.alt.type = mujoco.mjtOrientation.mjORIENTATION_QUAT
        for joint in fixed:
            spec.delete(joint)
