"""The result of one control cycle."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from .motion_steps import CycleResult

Status = Literal["moving", "reached", "stuck", "infeasible", "stopped", "too_near", "contact"]
"""Status of a motion. ``stuck``: safe, but without progress. ``infeasible``: not all safety bounds
can be satisfied, or a joint jumped. ``stopped``: at standstill after `ApproachController.stop`.
``too_near`` and ``contact``: an obstacle violated the margin, or touches the arm, which evades."""
Phase = Literal["approach", "retreat", "path", "stop", "plan"]
"""Phase of a motion. A stuck motion retreats before it tries again, or follows a planned path.
``plan``: the robot stands while a search runs in the background."""


@dataclass(frozen=True)
class ControlStep:
    """The result of one control cycle."""

    velocity: NDArray[np.float64]
    """Joint velocities to command, (n,), rad/s (m/s of sliding joints)."""
    status: Status
    """Status of the motion."""
    reason: str
    """Why the motion is stuck or infeasible; empty otherwise."""
    phase: Phase
    """Whether the motion drives the tasks, retreats, or follows a path."""
    errors: tuple[float, ...]
    """Norm of the error of each task, m or rad."""
    clearance: float
    """Minimum distance of all pairs nearer than the cut-off, m; inf if there are none."""
    beta: tuple[float, ...]
    """Weight of avoidance in each task (eq. 8)."""
    blocking: tuple[str, ...]
    """Names of the active constraints of the safety level, strongest first."""

    def __bool__(self) -> bool:
        return self.status in ("moving", "reached", "stopped")

    if not TYPE_CHECKING:

        def __getattr__(self, name):
            """Compute `blocking` when it is first read, because few cycles need the names."""
            if name != "blocking" or "_name_blocking" not in vars(self):
                raise AttributeError(f"{type(self).__name__!r} object has no attribute {name!r}")
            names = vars(self)["blocking"] = self._name_blocking()
            return names


def control_step(
    motion: CycleResult, status: Status, reason: str, phase: Phase, errors: tuple[float, ...]
) -> ControlStep:
    """Return the result of a cycle; ``errors`` are those of the tasks."""
    # The frozen constructor would take three times as long.
    step = object.__new__(ControlStep)
    vars(step).update(
        velocity=motion.command[0].copy(),
        status=status,
        reason=reason,
        phase=phase,
        errors=errors,
        clearance=motion.clearance,
        beta=motion.beta,
        _name_blocking=motion.name_blocking,
    )
    return step
