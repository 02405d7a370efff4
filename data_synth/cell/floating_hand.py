"""A parallel gripper without an arm: its boxes on a base that moves in straight lines."""

from __future__ import annotations

from typing import Any

import numpy as np

from eyehand.grasping.hands import ParallelHand

from ..mujoco_import import import_mujoco
from ..scenes.piece_object import PHYSICS_GROUP, set_grip_contact

AXES = "xyz"
BASE, PALM, FINGERS = "hand_base", "hand_palm", ("hand_right", "hand_left")
"""Names of the bodies. The right finger is at +x."""
BASE_MASS, FINGER_MASS = 0.81, 0.1
"""Masses of the original protocol's hand, kg."""
MAX_BASE_FORCE = 300.0
"""Maximum force of the base along each axis, N, as in the original."""
BASE_STIFFNESS, FINGER_STIFFNESS = 2e4, 1e4
"""Gains of the position servos, N/m. A finger that is 2 mm from its goal closes with full force."""
FINGER_DAMPING = 20.0
"""Damping of a finger, N s/m."""
_ARMATURE = 0.05
"""Inertia of the drives, kg. It keeps the fingers stable at a time step of 2 ms."""


def add_floating_hand(spec: Any, hand: ParallelHand, *, force: float, friction: float) -> None:
    """Add a hand to a world.

    The actuators ``hand_x``, ``hand_y`` and ``hand_z`` move the base along the world's axes. Its
    direction is the orientation of the body ``hand_palm``, set in the compiled model. Each finger
    has a position actuator of its body's name. An equality constraint keeps the fingers centred.

    Parameters
    ----------
    spec
        `MjSpec` of the world.
    hand
        The hand.
    force
        Maximum closing force of each finger, N.
    friction
        Coulomb friction coefficient of the hand.
    """
    mujoco = import_mujoco()
    base = spec.worldbody.add_body(name=BASE, gravcomp=1.0)
    for number, axis in enumerate(AXES):
        base.add_joint(
            name=f"hand_{axis}",
            type=mujoco.mjtJoint.mjJNT_SLIDE,
            axis=np.eye(3)[number],
            armature=_ARMATURE,
            damping=2.0 * np.sqrt(BASE_STIFFNESS * (BASE_MASS + 2 * FINGER_MASS)),
        )
        _add_servo(mujoco, spec, f"hand_{axis}", BASE_STIFFNESS, MAX_BASE_FORCE)
    base.mass, base.inertia, base.explicitinertial = 1e-3, [1e-6] * 3, True
    palm = base.add_body(name=PALM, gravcomp=1.0)
    palm.mass, palm.inertia, palm.explicitinertial = BASE_MASS, [1e-3] * 3, True
    _add_boxes(mujoco, palm, hand.fixed_boxes(), friction)
    boxes = hand.jaw_boxes(0.0).reshape(2, -1, 2, 3)
    for name, side, solids in zip(FINGERS, (1.0, -1.0), boxes, strict=True):
        finger = palm.add_body(name=name, gravcomp=1.0)
        finger.mass, finger.inertia, finger.explicitinertial = FINGER_MASS, [1e-5] * 3, True
        finger.add_joint(
            name=name,
            type=mujoco.mjtJoint.mjJNT_SLIDE,
            axis=[side, 0.0, 0.0],
            range=[0.5 * hand.min_opening, 0.5 * hand.stroke],
            limited=True,
            armature=_ARMATURE,
            damping=FINGER_DAMPING,
        )
        _add_boxes(mujoco, finger, solids, friction)
        _add_servo(mujoco, spec, name, FINGER_STIFFNESS, force)
    for finger in FINGERS:
        spec.add_exclude(bodyname1=PALM, bodyname2=finger)
    spec.add_exclude(bodyname1=FINGERS[0], bodyname2=FINGERS[1])
    centred = spec.add_equality(type=mujoco.mjtEq.mjEQ_JOINT, objtype=mujoco.mjtObj.mjOBJ_JOINT)
    centred.name1, centred.name2 = FINGERS
    centred.data[:5] = [0.0, 1.0, 0.0, 0.0, 0.0]
    centred.solref = [0.005, 1.0]


def _add_servo(mujoco: Any, spec: Any, joint: str, gain: float, force: float) -> None:
    servo = spec.add_actuator(name=joint, target=joint, trntype=mujoco.mjtTrn.mjTRN_JOINT)
    servo.gainprm[0], servo.biastype = gain, mujoco.mjtBias.mjBIAS_AFFINE
    servo.biasprm[:3] = [0.0, -gain, 0.0]
    servo.forcelimited, servo.forcerange = True, [-force, force]


def _add_boxes(mujoco: Any, body: Any, boxes: Any, friction: float) -> None:
    for low, high in boxes:
        geom = body.add_geom(type=mujoco.mjtGeom.mjGEOM_BOX, group=PHYSICS_GROUP)
        geom.pos, geom.size = 0.5 * (low + high), 0.5 * (high - low)
        geom.mass = 0.0
        set_grip_contact(geom, friction)
