"""Prepare a gripper with two jaws in the MuJoCo description of a robot."""

from __future__ import annotations

from typing import Any

from .jaw_mechanism import JawMechanism, limit_armature, make_servo
from .pad_friction import SLIDING_FRICTION, SPIN_FRICTION_M

TOOL_FRAME = "eyehand_tool"
"""Site of the tool frame that is added to a gripper."""

CONTACT_SOLREF, CONTACT_SOLIMP = [0.004, 1.0], [0.95, 0.99, 0.001, 0.5, 2.0]
"""Stiffness of the contacts of the jaws: the stiffest at a physics step of 2 ms. A contact is as
soft as the object is light. With the default, 35 N close the jaws through an object of 7 g."""


def fix_base(spec: Any, mechanism: JawMechanism) -> None:
    """Fix the palm of a gripper's spec (`MjSpec`): remove the joints that carry it.

    A free base, or a virtual arm of slides and hinges, makes a gripper float in its file. On the
    flange of an arm nothing drives them.
    """
    body = next(one for one in spec.bodies if one.name == mechanism.root)
    while body is not None and body.name != "world":
        for joint in list(body.joints):
            for motor in [one for one in spec.actuators if one.target == joint.name]:
                spec.delete(motor)
            spec.delete(joint)
        body = body.parent


def prepare_jaws(
    spec: Any, mechanism: JawMechanism, friction: float | None, *, prefix: str = ""
) -> None:
    """Add the tool frame, a servo and the friction of the pads to a robot's spec.

    The weight of all bodies is compensated, as the controllers of such robots do.

    Parameters
    ----------
    spec
        `MjSpec` of the robot.
    mechanism
        Its gripper.
    friction
        Sliding friction of the jaws; `SLIDING_FRICTION` if None.
    prefix
        Prefix of the gripper's names in the spec.
    """
    root = next(body for body in spec.bodies if body.name == prefix + mechanism.root)
    pose = mechanism.T_root_tool
    quaternion = pose.rotation.as_quat(scalar_first=True)
    root.add_site(name=TOOL_FRAME, pos=pose.translation, quat=quaternion)
    for motor, stiffness in zip(mechanism.motors, mechanism.stiffness, strict=True):
        make_servo(spec, prefix + motor, float(stiffness))
    joints = [prefix + name for name in mechanism.joints]
    limit_armature(spec, joints, least=float(len(mechanism.motors) > 1))
    for one, other in mechanism.overlaps:
        # Shapes of a linkage are rough. Its joints say how it moves.
        spec.add_exclude(bodyname1=prefix + one, bodyname2=prefix + other)
    sliding = SLIDING_FRICTION if friction is None else friction
    jaws = {prefix + name for side in mechanism.jaws for name in side}
    for body in spec.bodies[1:]:
        body.gravcomp = 1.0
        if body.name not in jaws:
            continue
        for geom in body.geoms:
            geom.priority, geom.condim = 1, 4
            geom.friction = [sliding, SPIN_FRICTION_M, geom.friction[2]]
            geom.solref, geom.solimp = CONTACT_SOLREF, CONTACT_SOLIMP
