"""Reach with a controller of the control basis, alone or with a search behind it."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from eyehand.control import ApproachController, ControlStep, JointPath, PlannedApproach


class ControlledReach:
    """A controller in a reaching scene, until it says that it is stuck."""

    def __init__(self, controller: ApproachController | PlannedApproach) -> None:
        self._controller = controller
        self.reason = ""
        """Why the last cycle's motion did not go on, or what held it back; empty when neither."""

    @property
    def paths(self) -> tuple[JointPath, ...]:
        """What its searches gave."""
        return tuple(getattr(self._controller, "paths", ()))

    def __call__(self, q: NDArray[np.float64]) -> tuple[NDArray[np.float64], str]:
        """Give the joint speeds (7,), rad/s, of a cycle; see `ReachMethod`."""
        cycle = self._controller.step(q)
        self.reason = said(cycle)
        return cycle.velocity, "stuck" if cycle.status == "stuck" else ""


def said(cycle: ControlStep) -> str:
    """Put a cycle's reason into words, or else what the safety level held back for."""
    return cycle.reason or ", ".join(cycle.blocking[:3])
