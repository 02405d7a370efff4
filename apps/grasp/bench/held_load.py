"""The predicted hold of a grasp, the load on a lifted object, and the force on its sides."""

from __future__ import annotations

from typing import TYPE_CHECKING

from eyehand.grasping import HandModel, HandReading, ParallelHand, plan_hold

if TYPE_CHECKING:
    from eyehand.data_synth.cell import SimRobot
    from eyehand.grasping import CycleInfo, SelectedGrasp

LOAD_DELAY_S = 0.1
"""Time of the check after which the load is added, s. Until then the lifted object comes to
rest."""
GRAVITY = 9.81


class HeldLoad:
    """The load on the object of one pick while the hand checks that it holds it.

    Parameters
    ----------
    robot
        The simulated robot.
    name
        Name of the object; empty without one.
    step
        Load during the check, as a multiple of the object's weight; 1 adds nothing.
    friction
        Sliding friction between pads and object.
    """

    def __init__(self, robot: SimRobot, name: str, step: float, friction: float) -> None:
        self._robot, self._name, self._step, self._friction = robot, name, step, friction
        self._weight = robot.mass(name) * GRAVITY if name else 0.0
        self._began: float | None = None
        self._force, self._least = 0.0, 0.0
        self.lifted = False
        """Whether the hand alone held the object when the check began."""

    @property
    def squeeze(self) -> float | None:
        """Mean force on the pads over the least one; None if the object was not lifted.

        The least force holds the load by friction alone: load over friction, summed over the pads.
        A shake needs more, and a hand that encloses the object needs less.
        """
        return self._force / self._least if self._least > 0.0 else None

    def update(self, cycle: CycleInfo) -> None:
        """Enter a control cycle, and set the load for the next one."""
        if not self._name:
            return
        if cycle.phase != "check":
            self.end()
            return
        time = cycle.reading.time
        if self._began is None:
            self._began, self.lifted = time, self._robot.is_lifted(self._name)
        share = self._step if time - self._began >= LOAD_DELAY_S else 1.0
        self._robot.set_load(self._name, (share - 1.0) * self._weight)
        if self._robot.is_lifted(self._name):
            self._force += self._true_force(cycle)
            self._least += share * self._weight / self._friction

    def _true_force(self, cycle: CycleInfo) -> float:
        """Return the sum of the forces on all pads, N; exact for a hand with fingers."""
        hand = self._robot.exact_hand_reading()
        return float((hand.forces if isinstance(hand, HandReading) else cycle.force).sum())

    def end(self) -> None:
        """Remove the load. A pick that fails in the check enters no further phase."""
        if self._began is not None:
            self._began = None
            self._robot.set_load(self._name, 0.0)


def predicted_hold(choice: SelectedGrasp, hand: HandModel | ParallelHand) -> float | None:
    """Return the probability that a grasp holds; None for a gripper with jaws."""
    solid = choice.target.fit.superquadric
    if solid is None or isinstance(hand, ParallelHand):
        return None
    return plan_hold(choice.plan, solid, hand)
