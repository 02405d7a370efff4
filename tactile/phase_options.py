"""Options of the phases of a touch."""

from __future__ import annotations

from dataclasses import dataclass, fields

from eyehand.errors import InputError

MAX_BLIND_TRAVEL = 0.008
"""Maximum motion towards the object within the delay and the lag, m. Simulated landings of a pad of
4 mm foam on a rigid pen reached 85 N at 12 mm, and stayed below 60 N at 6 mm."""


@dataclass(frozen=True)
class PhaseOptions:
    """Speeds, time limits and safety limits of a touch.

    Raises
    ------
    InputError
        If a value is negative or NaN.
    """

    approach_speed: float = 0.01
    """Speed towards the object before contact, m/s. A higher speed saves time and raises the peak
    force on stiff objects. 0 waits for the object to come."""
    hold_seconds: float = 10.0
    """Maximum wait for a contact, s."""
    touch_pressure: float = 50.0
    """Pressure that counts as contact, Pa. It must be above the noise of the pad."""
    task_seconds: float = float("inf")
    """Duration of the task, s. The task then ends with the outcome `done`."""
    pressure_limit: float = 4000.0
    """Pressure that ends the task, Pa. It must be below the saturation of the tactels."""
    force_limit: float = 30.0
    """Force that ends the task, N."""
    peak_limit: float = float("inf")
    """Averaged pressure since the contact, as a multiple of the goal, above which a contact ends
    once it has settled. A low limit rejects contacts that pressed too hard for a moment."""
    saturated_share: float = 0.25
    """Share of saturated tactels in the contact that ends the task. Beyond it, the measured force
    and pressure are too low for the two other limits."""
    searches: int = 3
    """Attempts to find a lost contact again, each at another place."""
    search_seconds: float = 8.0
    """Time limit of all attempts of one search, s."""
    jump: float = 0.012
    """Motion of the centre of pressure within one cycle that means another contact, m."""
    pad_half_size: tuple[float, float] = (0.04, 0.04)
    """Half the pad's extent along x and y, m."""

    def __post_init__(self) -> None:
        for field in fields(self):
            value = getattr(self, field.name)
            for number in value if isinstance(value, tuple) else (value,):
                if not number >= 0:
                    raise InputError(f"{field.name} must be >= 0, got {value}")

    def check_delay(self, delay: float) -> None:
        """Check that the pad stops soon after contact.

        Parameters
        ----------
        delay
            Time after which sensor and arm react to a contact, s.

        Raises
        ------
        InputError
            If the approach moves the pad by more than `MAX_BLIND_TRAVEL` within it.
        """
        if self.approach_speed * delay > MAX_BLIND_TRAVEL:
            raise InputError(
                f"approach_speed must be <= {MAX_BLIND_TRAVEL / delay:.3f} m/s, because sensor and "
                f"arm react after {1e3 * delay:.0f} ms, got {self.approach_speed}"
            )
