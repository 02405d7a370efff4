"""Options of a pick."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal, get_args

from eyehand.control import ControlOptions, PlannerOptions
from eyehand.errors import InputError

from .depth_correction import CORRECTED_SCALE_ERROR
from .hands import GripOptions
from .jaws import JawOptions

MAX_VALUES = {
    "speed": 2.0,
    "carry_speed": 2.0,
    "pre_grasp_distance": 0.5,
    "lift_height": 1.0,
    "drop_height": 0.5,
    "max_contact_force": 1e3,
    "check_seconds": 60.0,
    "shake_seconds": 60.0,
    "max_attempts": 100,
}
"""Greatest value of each numeric option. A length beyond it is in mm or cm."""
POSITIVE = ("speed", "carry_speed", "max_contact_force")
"""Options that must not be 0, because nothing would move."""


Balancing = Literal["off", "seen", "felt"]
"""Source of the centre of mass for `PickOptions.balance`."""


@dataclass(frozen=True)
class PickOptions:
    """Options of a pick: speed, distances, retries, control and grip.

    Raises
    ------
    InputError
        If a value is out of range.
    """

    control: ControlOptions = field(
        default_factory=lambda: ControlOptions(dt=0.004, margin=0.006, influence=0.04)
    )
    """Control options of motions far from the object; the period is taken from the robot. On a
    packed table the free space is a few centimetres. A larger influence keeps the hand out of
    it."""
    planner: PlannerOptions = field(default_factory=lambda: PlannerOptions(rollouts=85))
    """Options of the planner, which is used when a motion is stuck."""
    grip: GripOptions = field(default_factory=GripOptions)
    """Options of closing the hand."""
    jaws: JawOptions = field(
        default_factory=lambda: JawOptions(depth_error=CORRECTED_SCALE_ERROR, per_object=8)
    )
    """Options of planning grasps of grippers with two jaws. Several grasps of each object are
    planned, because the arm may not reach the best. The camera of a cell is calibrated."""
    follow_load: bool = True
    """Whether the grip follows the load that the wrist measures, instead of the estimated mass. It
    needs a robot that measures `RobotReading.wrench`, and takes about half a second."""
    balance: Balancing = "off"
    """Whether the hand slides along the resting object after contact, until the opposing axis is
    near the centre of mass and the fingers are flat on the touched face. It takes 1.5 s.

    - off: it lifts the grasp as it is.
    - seen: the centre of mass is that of the solid.
    - felt: the wrist measures it when it raises the object by 6 mm."""
    speed: float = 1.0
    """Factor on the speeds of the arm with an empty hand and during the lift. A factor below 1
    extends the time limits as well. Faster saves time, but hits unseen obstacles harder."""
    carry_speed: float = 0.6
    """Speed of the hand with an object in it, m/s. Faster needs a stronger grip."""
    pre_grasp_distance: float = 0.025
    """Free distance between the fingertips and the object at the pre-grasp, m. Longer approaches
    straighter, but needs more free space."""
    lift_height: float = 0.1
    """Height of the lift, m."""
    drop_height: float = 0.012
    """Height of the object above the tray's floor when the hand opens, m. Lower drops it more
    gently, but may push it into the floor."""
    max_contact_force: float = 10.0
    """Force on a pad at which a motion far from the object stops, N. Higher ignores light objects
    that the hand brushes aside."""
    check_seconds: float = 0.2
    """Time for which the object is observed in the lifted hand, s. Longer detects slower slip."""
    shake_seconds: float = 0.0
    """Time for which the lifted object is shaken to test the grip, s; 0 skips the test."""
    max_attempts: int = 2
    """Maximum number of different grasps tried on one object."""

    def __post_init__(self) -> None:
        for name, most in MAX_VALUES.items():
            value = getattr(self, name)
            if not isinstance(value, int | float) or not 0.0 <= value <= most:
                raise InputError(f"pick option {name} must be 0 to {most:g}, got {value!r}")
            if value == 0.0 and name in POSITIVE:
                raise InputError(f"pick option {name} must be > 0, got {value}")
        if self.balance not in get_args(Balancing):
            names = ", ".join(get_args(Balancing))
            raise InputError(f"pick option balance must be one of {names}, got {self.balance!r}")
        if self.max_attempts < 1:
            raise InputError(f"pick option max_attempts must be >= 1, got {self.max_attempts}")

    def time_limit(self, seconds: float) -> float:
        """Return the time limit of a motion, s, given its limit at normal speed, s."""
        return max(1.0, 1 / self.speed) * seconds
