"""Every choice of the pick, with its unit and what it trades."""

from __future__ import annotations

from dataclasses import dataclass, field

from eyehand.control import ControlOptions, PlannerOptions
from eyehand.errors import InputError

from .grip_options import GripOptions

MOST = 1e3
"""No option in SI units is as large."""
NOT_ZERO = ("gain", "ramp_seconds", "reached", "off", "bump_force", "touch_force")
"""Options besides speeds that nothing happens without."""


@dataclass(frozen=True)
class PickOptions:
    """Speeds, distances and time-outs of a pick, phase by phase.

    Raises
    ------
    InputError
        If a value is out of range.
    """

    control: ControlOptions = field(
        default_factory=lambda: ControlOptions(dt=0.004, margin=0.006, influence=0.04)
    )
    """Of the arm's ways far from the object; its period is the robot's. On a packed table the free
    space is centimetres: a wider influence keeps the hand out of it."""
    planner: PlannerOptions = field(default_factory=lambda: PlannerOptions(rollouts=85))
    """Of the search where such a way is stuck."""
    grip: GripOptions = field(default_factory=GripOptions)
    """Of the closing hand."""
    near_margin: float = 0.003
    """Distance kept from table and neighbours around the grasp, m: less reaches what lies lower and
    closer, and forgives less of what was seen wrong."""
    near_influence: float = 0.015
    """Distance below which they repel there, m."""
    transit_speed: float = 0.8
    """Of the hand far from objects, m/s: faster saves time, and hits harder what was not seen."""
    carry_speed: float = 0.6
    """The same with an object in it, m/s: faster asks more of the grip."""
    transit_turn_speed: float = 2.5
    """Of its turning there, rad/s."""
    gain: float = 8.0
    """How fast the last of an error is taken away, 1/s: higher settles sooner, and asks more of the
    arm's servos."""
    ramp_seconds: float = 0.15
    """How long a motion takes to come up to its speed, s: longer jerks less at what is held."""
    before: float = 0.025
    """Free space between the tips and the object where the last straight way begins, m: longer
    comes in straighter, and is farther."""
    approach_speed: float = 0.2
    """Of that last way, m/s."""
    reached: float = 0.004
    """Error at which a place counts as reached, m or rad: the hand's compliance takes up the
    rest."""
    off: float = 0.01
    """Error at which a motion that only leads away counts as done, m."""
    slack: float = 0.006
    """Error with which the grasp still begins where the arm comes no nearer, m ..."""
    turn_slack: float = 0.09
    """... and rad, 5 degrees: at the edge of reach the hand leans a little."""
    touch_force: float = 0.6
    """Force on any pad that counts as touch, N."""
    bump_force: float = 10.0
    """Force on any pad at which a way far from the object ends, N: it met what was not seen. Light
    things are brushed aside with less."""
    shift: float = 0.008
    """How far the next try goes sideways from where a finger met the object too early, m."""
    contact_retries: int = 2
    """How often the hand backs off and comes again after such a touch."""
    regrasps: int = 1
    """How often the hand backs off and closes again after it lost what it had touched."""
    palm_search: float = 0.012
    """How far a power grasp goes on past its goal to feel the object with the palm, m."""
    palm_speed: float = 0.03
    """Of the hand meanwhile, m/s."""
    lift_height: float = 0.1
    """m."""
    lift_speed: float = 0.35
    """m/s."""
    over_tray: float = 0.03
    """How far the object passes over the tray's walls, m."""
    drop_height: float = 0.012
    """How far the object's lowest point is over the tray's floor when the hand opens, m."""
    near_seconds: float = 0.3
    """How long the arm tries to come nearer once it is near enough for the grasp to begin, s."""
    pre_grasp_seconds: float = 9.0
    """Longest way to the pre-grasp, robot time, s: a way around what is in the way takes 3 to 6."""
    approach_seconds: float = 3.0
    """Longest last way, s."""
    close_seconds: float = 3.0
    """Longest closing of the hand, s."""
    grip_seconds: float = 0.15
    """How long the grip settles before the lift, s."""
    lift_seconds: float = 2.5
    """Longest lift, s."""
    check_seconds: float = 0.2
    """How long the object is watched in the lifted hand, s."""
    shake_seconds: float = 0.0
    """How long the lifted object is shaken to try the grip, s; 0 does not."""
    place_seconds: float = 8.0
    """Longest way to the tray, s."""
    down_patience: float = 0.2
    """How long the way down into the tray may go without progress before the hand opens, s."""
    open_seconds: float = 0.25
    """How long the hand takes to open, s."""
    tries: int = 2
    """Ways to grasp one object before it is left alone."""

    def __post_init__(self) -> None:
        for name, value in vars(self).items():
            if not isinstance(value, (int, float)):
                continue
            if not 0.0 <= value < MOST:
                raise InputError(f"pick option {name} must lie in [0, {MOST:g}), got {value}")
            if value == 0.0 and (name.endswith("_speed") or name in NOT_ZERO):
                raise InputError(f"pick option {name} must be > 0")
        if self.tries < 1 or min(self.contact_retries, self.regrasps) < 0:
            raise InputError(
                f"need tries >= 1, contact_retries and regrasps >= 0, got {self.tries}, "
                f"{self.contact_retries}, {self.regrasps}"
            )
