"""Every choice of the phase machine, with its unit and what it trades."""

from __future__ import annotations

from dataclasses import dataclass, fields

from eyehand.errors import InputError


@dataclass(frozen=True)
class PhaseOptions:
    """Speeds, bounds and patience of the way to a contact and back.

    Raises
    ------
    InputError
        If a value is out of its range.
    """

    pose_tolerance: float = 0.002
    """Pose error below which the work area counts as reached, m."""
    angle_tolerance: float = 0.02
    """Likewise, rad."""
    move_seconds: float = 30.0
    """Longest way to the work area, s."""
    approach_speed: float = 0.01
    """Speed towards the object while nothing touches, m/s: a stiff object answers a landing with
    a peak that grows with it. 0 holds and waits for the object to come."""
    approach_travel: float = 0.05
    """Longest way towards the object, m."""
    hold_seconds: float = 10.0
    """Longest wait for a contact, s."""
    touch_pressure: float = 50.0
    """Pressure that counts as contact, Pa, above what noise can feign."""
    touch_cycles: int = 3
    """Cycles in a row it must be there."""
    task_seconds: float = float("inf")
    """How long the task runs before it ends as done, s."""
    lost_seconds: float = 0.06
    """Time without contact that counts as lost, s; shorter flickers are waited out at rest."""
    pressure_limit: float = 4000.0
    """Pressure that ends the task, Pa: below what the tactels saturate at."""
    force_limit: float = 30.0
    """Force that ends it, N."""
    saturated_share: float = 0.25
    """Share of the contact's tactels that may feel more than they can tell: beyond it force and
    pressure are told too low to be guarded by."""
    overload_cycles: int = 2
    """Cycles in a row that one of the three must be exceeded."""
    back_off_speed: float = 0.05
    """Speed away from the object, m/s."""
    back_off_distance: float = 0.01
    """Way to go on after nothing touches any more, m."""
    back_off_travel: float = 0.05
    """Longest way away, m; an object that follows farther still touches at the end."""
    searches: int = 3
    """Tries to find a lost contact again, each at another place."""
    losses: int = 6
    """Losses in one task after which it ends even if each was found again."""
    search_lift: float = 0.005
    """Way off the object before a try, m."""
    search_step: float = 0.01
    """Way along the surface between two tries, m."""
    search_speed: float = 0.05
    """Speed of that way, m/s."""
    search_depth: float = 0.01
    """Way beyond where the contact was lost that a try descends, m."""
    search_seconds: float = 8.0
    """Longest search, all tries together, s."""
    swing: float = 0.5
    """Smallest swing of the pressure that may be an oscillation, as a share of the goal's."""
    swings: int = 5
    """Swings in a row without shrinking that end the task."""
    swing_seconds: float = 0.5
    """Longest time of one such swing, s."""
    miss: float = 0.1
    """Mean error of the averaged pressure over a span that counts as a miss, as a share of the
    goal; without outer motion only. inf never does."""
    calm: float = 0.08
    """Its standard deviation over a span up to which it is calm, likewise: a swing too small for
    `swing` must not last either. Pens, boxes and balls within the limits stay below 0.01."""
    miss_seconds: float = 0.5
    """Length of a span, s: a landing's must not fill one."""
    miss_spans: int = 3
    """Spans in a row, none better than the one before, that end the task: an object that is turned
    by hand is off for two, and then better."""
    jump: float = 0.012
    """Way of the centre of pressure in one cycle that is another contact, m."""
    jumps: int = 4
    """Jumps within a second that end the task: two contacts that swap, or noise."""
    border: float = 0.006
    """Distance to the pad's border below which the imprint is cut off, m."""
    border_seconds: float = 2.0
    """Time that the centre of pressure may stay there, s."""
    pad_half_size: tuple[float, float] = (0.04, 0.04)
    """Half the pad's extent along x and y, m."""
    push_travel: float = 0.03
    """Way of pressing without coming near the goal's pressure, m, that ends the task: the object
    gives way, or the pad does not feel it."""
    near_goal: float = 0.5
    """Share of the goal's pressure that counts as near."""
    least_trusted: float = 0.75
    """Share of trusted tactels below which the pad is not used."""

    def __post_init__(self) -> None:
        for field in fields(self):
            value = getattr(self, field.name)
            for number in value if isinstance(value, tuple) else (value,):
                if not number >= 0:
                    raise InputError(f"{field.name} must be >= 0, got {value}")
        for name in ("back_off_speed", "back_off_distance", "back_off_travel", "search_speed"):
            if not 0 < getattr(self, name) < float("inf"):
                raise InputError(f"{name} must be finite and > 0, got {getattr(self, name)}")
        if not 0 < self.miss_seconds < float("inf") or self.miss_spans < 1:
            raise InputError(
                "miss_seconds must be finite and > 0 and miss_spans >= 1, got "
                f"{self.miss_seconds} and {self.miss_spans}"
            )
        if self.back_off_travel < self.back_off_distance:
            raise InputError(
                f"back_off_travel must be >= back_off_distance, got {self.back_off_travel}"
            )
