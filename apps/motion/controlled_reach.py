"""Reach with the approach controller alone."""

from __future__ import annotations

from typing import TYPE_CHECKING

from eyehand.control.approach import ApproachController

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from eyehand.control.approach import Cycle
    from eyehand.control.collision_world import CollisionWorld
    from eyehand.control.options import ControlOptions
    from eyehand.control.task import Aim


class ControlledReach:
    """The approach controller in a reaching scene, until it says that it is stuck.

    Parameters
    ----------
    world
        Arm and obstacles.
    aim
        What to reach.
    options
        Of the controller.
    """

    def __init__(self, world: CollisionWorld, aim: Aim, options: ControlOptions) -> None:
        self._controller = ApproachController(world, (aim,), options)
        self.reason = ""
        """Why the last cycle's motion did not go on, or what held it back; empty when neither."""

    def __call__(self, q: NDArray[np.float64]) -> tuple[NDArray[np.float64], str]:
        """Give the joint speeds (7,), rad/s, of a cycle; see `ReachMethod`."""
        cycle = self._controller.step(q)
        self.reason = said(cycle)
        return cycle.velocity, "stuck" if cycle.status == "stuck" else ""


def said(cycle: Cycle) -> str:
    """Put a cycle's reason into words, or else what the safety level held back for."""
    return cycle.reason or ", ".join(cycle.blocking[:3])
