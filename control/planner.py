"""Paths around local minima: a search tree of roll-outs of the controller.

The division of work between a local controller and a global search follows Behnisch et al. 2011.
The tree grows in the three dimensions of the frame's position, after LaValle 1998. Its edges are
motions of the controller itself, so a path that is found has already been driven in simulation.
"""

from __future__ import annotations

import math
import time
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from .approach import RETREAT_SPEED, ApproachController, counted, retreat_configurations
from .planner_options import PlannerOptions
from .tasks.position import Position
from .tasks.posture import Posture

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from .collision_world import CollisionWorld
    from .options import ControlOptions
    from .tasks.task import Task


MAX_GUESS_STEP = math.pi
"""Longest step of all joints with which the goal of the tasks is guessed, rad or m: beyond half a
turn a straight step means nothing."""
PATIENCE = 0.4
"""A roll-out ends after this time without progress, s of motion: shorter wastes less time in dead
ends, and gives up where the path bends."""
GOAL_SHARE = 0.3
"""Share of roll-outs that head for the goal: more is faster when there are few obstacles."""
MIN_STEP = 0.02
"""Roll-outs that end nearer to a known place, m, are discarded."""
FAILURE_COST = 0.1
"""Distance that a place counts farther from the goal for each failed roll-out from it, m."""
POSTURE_WEIGHT = 0.1
"""Weight of a rad between postures beside a m between places, where places are compared: elbows
matter too."""


@dataclass(frozen=True)
class JointPath:
    """A path, or (false in a condition) the reason why none was found."""

    found: bool
    """Whether the path ends with all tasks reached."""
    postures: NDArray[np.float64]
    """Joint positions (N, n) along the path, the start first."""
    dt: float
    """Time from one posture to the next, s."""
    reason: str
    """Why no path was found: what blocked the last roll-out to the goal; empty otherwise."""
    rollouts: int
    """Number of roll-outs."""
    places: int
    """Number of places in the tree at the end."""
    seconds: float
    """Time the search took, s."""

    def __bool__(self) -> bool:
        return self.found


@dataclass(frozen=True)
class _Place:
    position: NDArray[np.float64]
    q: NDArray[np.float64]
    left: float
    """Sum of the errors of the tasks that count."""
    parent: int
    postures: NDArray[np.float64]
    """(N, n) from the parent's posture, that one not included."""


@dataclass(frozen=True)
class _Rollout:
    postures: NDArray[np.float64]
    reached: bool
    reason: str
    left: float


def plan(
    world: CollisionWorld,
    tasks: Sequence[Task],
    q: NDArray[np.float64],
    options: ControlOptions,
    planner: PlannerOptions | None = None,
) -> JointPath:
    """Search for a path from joint positions q (n,) to a posture that reaches all tasks.

    Each iteration rolls out the controller. It starts either from the known place nearest to a
    random position and drives there, or from the place nearest to the goal and drives the tasks
    themselves. Places with failed roll-outs to the goal count as farther. Every new place is
    followed by a roll-out to the goal.

    Raises
    ------
    InputError
        If q has another shape, or is not finite.
    """
    planner = planner or PlannerOptions()
    rng = np.random.default_rng(planner.seed)
    search = _Search(world, tuple(tasks), options, planner)
    search.add(-1, np.zeros((0, len(q))), np.asarray(q, dtype=np.float64))
    low, high = search.bounds()
    found = search.has_rollouts() and (search.try_goal(0) or search.try_retreats())
    while not found and search.has_rollouts():
        if rng.random() < GOAL_SHARE:
            found = search.try_goal(search.most_promising())
            continue
        new = search.extend(rng.uniform(low, high))
        found = new >= 0 and search.try_goal(new)
    return JointPath(
        found,
        search.path(len(search.places) - 1 if found else search.nearest_to_goal()),
        planner.dt,
        "" if found else search.reason,
        search.rollouts,
        len(search.places),
        time.perf_counter() - search.began,
    )


class _Search:
    def __init__(
        self,
        world: CollisionWorld,
        tasks: tuple[Task, ...],
        options: ControlOptions,
        planner: PlannerOptions,
    ) -> None:
        self.world = world
        self.tasks = tasks
        self.counted = [tasks[place] for place in counted(tasks)]
        self.options = replace(
            options,
            dt=planner.dt,
            patience=PATIENCE,
            retreats=0,
            eta=min(options.eta, options.eta * options.dt / planner.dt),
        )
        self.planner = planner
        self.places: list[_Place] = []
        self.failures: list[int] = []
        self.rollouts = 0
        self.reason = "no roll-outs to search with"
        self.began = time.perf_counter()

    def has_rollouts(self) -> bool:
        """Return whether the budget of roll-outs is not spent."""
        return self.rollouts < self.planner.rollouts

    def add(self, parent: int, postures: NDArray[np.float64], q: NDArray[np.float64]) -> int:
        state = self.world.robot.at(q)
        left = sum(task.at(state).unmet for task in self.counted)
        self.places.append(_Place(state.position, state.q, left, parent, postures))
        self.failures.append(0)
        return len(self.places) - 1

    def bounds(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return the corners (3,), (3,) of the box in which positions are drawn."""
        start = self.places[0]
        state = self.world.robot.at(start.q)
        ends = [start.position]
        for task in self.tasks:
            rows = task.at(state)
            # The frame after one straight step that removes the whole error.
            step = np.linalg.pinv(rows.jacobian) @ rows.error
            # Near a singular posture that step would be far too long.
            step *= MAX_GUESS_STEP / max(float(np.linalg.norm(step)), MAX_GUESS_STEP)
            ends.append(start.position + state.jacobian[:3] @ step)
        corners = np.array(ends)
        beyond = self.planner.reach_beyond
        return corners.min(axis=0) - beyond, corners.max(axis=0) + beyond

    def most_promising(self) -> int:
        cost = FAILURE_COST
        scores = [
            place.left + cost * failed
            for place, failed in zip(self.places, self.failures, strict=True)
        ]
        return int(np.argmin(scores))

    def nearest_to_goal(self) -> int:
        return int(np.argmin([place.left for place in self.places]))

    def try_goal(self, index: int) -> bool:
        """Drive the tasks from a place; return whether they were reached, in the last place."""
        place = self.places[index]
        result = self.roll_out(place.q, self.tasks)
        if result.reached:
            self.add(
                index, result.postures, result.postures[-1] if len(result.postures) else place.q
            )
            return True
        self.failures[index] += 1
        self.reason = result.reason
        end = self._keep(index, result)
        if end >= 0:
            self.failures[end] += 1
        return False

    def try_retreats(self) -> bool:
        """Drive to each retreat configuration, and the tasks from there."""
        for configuration in retreat_configurations(self.world.robot):
            task = Posture(configuration, speed=RETREAT_SPEED)
            new = self._keep(0, self.roll_out(self.places[0].q, (task,)))
            if new >= 0 and self.try_goal(new):
                return True
        return False

    def extend(self, target: NDArray[np.float64]) -> int:
        """Roll out towards a position from the nearest place; return the new place, or -1."""
        away = [float(np.linalg.norm(place.position - target)) for place in self.places]
        index = int(np.argmin(away))
        result = self.roll_out(self.places[index].q, (Position(target),))
        return self._keep(index, result)

    def roll_out(self, q: NDArray[np.float64], tasks: tuple[Task, ...]) -> _Rollout:
        self.rollouts += 1
        controller = ApproachController(self.world, tasks, self.options)
        postures = []
        left = float("inf")
        reason = "longest roll-out"
        for _ in range(round(self.planner.longest / self.planner.dt)):
            cycle = controller.step(q)
            left = sum(cycle.errors)
            if cycle.status != "moving":
                reason = cycle.reason
                break
            q = q + self.planner.dt * cycle.velocity
            postures.append(q)
        reached = reason == ""
        return _Rollout(np.array(postures).reshape(-1, len(q)), reached, reason, left)

    def path(self, index: int) -> NDArray[np.float64]:
        pieces = []
        while index > 0:
            pieces.append(self.places[index].postures)
            index = self.places[index].parent
        return np.vstack([self.places[0].q[None], *reversed(pieces)])

    def _keep(self, parent: int, result: _Rollout) -> int:
        if not len(result.postures):
            return -1
        q = result.postures[-1]
        position = self.world.robot.at(q).position
        weight = POSTURE_WEIGHT
        for place in self.places:
            gap = np.linalg.norm(place.position - position) + weight * np.linalg.norm(place.q - q)
            if gap < MIN_STEP:
                return -1
        return self.add(parent, result.postures, q)
