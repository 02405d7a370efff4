"""Options of a command that choose a parallel gripper, by name, file or sizes."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from eyehand.errors import InputError
from eyehand.grasping import generic_jaw, load_hand
from eyehand.grasping.hands import built_in_hands

if TYPE_CHECKING:
    from eyehand.grasping import ParallelHand

MAX_SIZE_MM = 1000.0
GENERIC = "generic"


@dataclass(frozen=True)
class JawChoice:
    """Options that choose the gripper."""

    hand: str | None = None
    """Gripper: panda, 2f85, 2f140, hande, wsg50, allegro, shadow, or the JSON file of its
    description, which eyehand hand describe writes."""
    stroke: float | None = None
    """Generic gripper: maximum distance between the pads, mm."""
    finger_depth: float | None = None
    """Generic gripper: distance of the fingertips from the palm, mm."""
    finger_width: float | None = None
    """Generic gripper: width of a finger across the closing direction, mm."""
    joint_prefix: str = ""
    """Text before the names of the gripper's joints in the postures, as in a ROS description:
    panda_ makes panda_finger_joint1."""

    def load(self) -> ParallelHand:
        """Return the description of the gripper.

        Raises
        ------
        InputError
            If no gripper is chosen, or it is unknown, or a size is out of range.
        """
        hand = self._chosen()
        joints = tuple(replace(joint, name=self.joint_prefix + joint.name) for joint in hand.joints)
        return replace(hand, joints=joints) if self.joint_prefix else hand

    def _chosen(self) -> ParallelHand:
        sizes = {
            name: value
            for name in ("stroke", "finger_depth", "finger_width")
            if (value := getattr(self, name)) is not None
        }
        options = ", ".join(f"--{name.replace('_', '-')}" for name in sizes)
        if self.hand is None and not sizes:
            raise InputError(
                f"give the gripper: --hand NAME ({', '.join(built_in_hands())}), --hand FILE.json, "
                "or --stroke MM for a generic one"
            )
        if not sizes:
            assert self.hand is not None
            return load_hand(self.hand)
        if self.hand not in (None, GENERIC):
            raise InputError(f"{options} describe a generic gripper, and --hand names {self.hand}")
        for name, value in sizes.items():
            if not (math.isfinite(value) and 0.0 < value < MAX_SIZE_MM):
                option = f"--{name.replace('_', '-')}"
                raise InputError(f"{option} must be above 0 and below 1000 mm, got {value:g}")
        return generic_jaw(**{name: 1e-3 * value for name, value in sizes.items()})
