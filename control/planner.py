"""Paths around local minima: a search tree of roll-outs of the controller.

A roll-out simulates the controller from given joint positions until it stops. The division of work
between a local controller and a global search follows Behnisch et al. 2011. The tree grows in the
three dimensions of the frame's position, after LaValle 1998. Its edges are roll-outs, so the
controller has already driven every path that is found, in simulation.
"""

from __future__ import annotations

import math
import time
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from .approach import ApproachController, counted
from .collision_world import CollisionWorld
from .joint_path import JointPath, resample_path
from .joint_planner import find_path
from .options import ControlOptions, PlannerOptions
from .retreat import RETREAT_SECONDS, RETREAT_SPEED, retreat_configurations
from .tasks.position import Position
from .tasks.posture import Posture
from .tasks.task import Task

MAX_GUESS_STEP = math.pi
"""Maximum norm of the joint step that estimates where the frame ends, rad or m. Beyond half a turn
the linear estimate is meaningless."""
PATIENCE = 0.4
"""A roll-out ends after this time without progress, s of motion. A shorter time wastes less in dead
ends, and gives up where the path bends."""
PREDICTED = 12.0
"""Time limit of a predicted motion, s."""
GOAL_PROBABILITY = 0.3
"""Probability that a roll-out heads for the goal. More is faster when there are few obstacles."""
MIN_STEP = 0.02
"""A roll-out that ends nearer than this to a known node is discarded, m."""
FAILURE_COST = 0.1
"""Penalty on the distance of a node from the goal for each failed roll-out from it, m."""
JOINT_WEIGHT = 0.1
"""Weight of the joint distance of two nodes, m/rad, beside the distance of their positions. The
same position with another elbow is another node."""


@dataclass
class _Node:
    position: NDArray[np.float64]
    """Origin of the controlled frame (3,), m, world."""
    q: NDArray[np.float64]
    error: float
    """Sum of the errors of the tasks that decide whether the motion is reached."""
    parent: int
    configurations: NDArray[np.float64]
    """(N, n) from the parent's configuration to this one; the parent's is not included."""
    failures: int = 0
    """Number of failed roll-outs to the goal."""


@dataclass(frozen=True)
class _Rollout:
    configurations: NDArray[np.float64]
    """(N, n); the start is not included."""
    reason: str
    """Why it did not reach its tasks; empty if it did."""


def plan(
    world: CollisionWorld,
    tasks: Sequence[Task],
    q: NDArray[np.float64],
    options: ControlOptions,
    planner: PlannerOptions | None = None,
) -> JointPath:
    """Search for a path from joint positions q (n,) to a configuration that reaches all tasks.

    Each iteration rolls out the controller in one of two ways. It drives from the node nearest to a
    random position to that position, or from the node nearest to the goal to the tasks themselves.
    Nodes with failed roll-outs to the goal count as farther. Every new node is followed by a
    roll-out to the goal.

    Before that, it drives to the goal, to home and to its mirror image as far as it can, and
    searches a path in the joint space from where these roll-outs end.

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
    found = search.has_rollouts() and (
        search.try_goal(0) or search.try_retreats() or search.try_paths()
    )
    while not found and search.has_rollouts():
        if rng.random() < GOAL_PROBABILITY:
            found = search.try_goal(search.most_promising())
            continue
        new = search.extend(rng.uniform(low, high))
        found = new >= 0 and search.try_goal(new)
    return JointPath(
        found,
        search.path(len(search.nodes) - 1 if found else search.nearest_to_goal()),
        planner.dt,
        "" if found else search.reason,
        search.rollouts,
        len(search.nodes),
        time.perf_counter() - search.began,
    )


def predict(
    world: CollisionWorld,
    tasks: Sequence[Task],
    q: NDArray[np.float64],
    options: ControlOptions,
    planner: PlannerOptions,
) -> tuple[bool, float]:
    """Simulate the controller from q (n,); return whether it reaches the tasks, and its time, s."""
    search = _Search(world, tuple(tasks), options, planner)
    result = search.roll_out(q, tuple(tasks), PREDICTED)
    return not result.reason, planner.dt * len(result.configurations)


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
        self.counted = [tasks[index] for index in counted(tasks)]
        self.options = replace(
            options,
            dt=planner.dt,
            patience=PATIENCE,
            retreats=0,
            eta=min(options.eta, options.eta * options.dt / planner.dt),
        )
        self.planner = planner
        self.nodes: list[_Node] = []
        self.rollouts = 0
        self.reason = "the planner may use no roll-outs"
        self.began = time.perf_counter()

    def has_rollouts(self) -> bool:
        """Return whether there is budget for another roll-out."""
        return self.rollouts < self.planner.rollouts

    def add(self, parent: int, configurations: NDArray[np.float64], q: NDArray[np.float64]) -> int:
        """Add a node at q (n,); return its index."""
        state = self.world.robot.at(q)
        error = sum(task.at(state).unmet for task in self.counted)
        self.nodes.append(_Node(state.position, state.q, error, parent, configurations))
        return len(self.nodes) - 1

    def bounds(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return the corners (3,), (3,) of the box in which positions are drawn."""
        start = self.nodes[0]
        state = self.world.robot.at(start.q)
        ends = [start.position]
        for task in self.tasks:
            rows = task.at(state)
            # The frame after one linear step that removes the whole error.
            step = np.linalg.pinv(rows.jacobian) @ rows.error
            # Near a singular configuration that step would be far too long.
            step *= MAX_GUESS_STEP / max(float(np.linalg.norm(step)), MAX_GUESS_STEP)
            ends.append(start.position + state.jacobian[:3] @ step)
        corners = np.array(ends)
        beyond = self.planner.reach_beyond
        return corners.min(axis=0) - beyond, corners.max(axis=0) + beyond

    def most_promising(self) -> int:
        """Return the node nearest to the goal, with the penalty of its failures."""
        return int(np.argmin([node.error + FAILURE_COST * node.failures for node in self.nodes]))

    def nearest_to_goal(self) -> int:
        """Return the node with the smallest error."""
        return int(np.argmin([node.error for node in self.nodes]))

    def try_goal(self, index: int) -> bool:
        """Drive the tasks from a node; if they are reached, add the last node and return true."""
        node = self.nodes[index]
        result = self.roll_out(node.q, self.tasks)
        if not result.reason:
            self.add(index, result.configurations, [node.q, *result.configurations][-1])
            return True
        node.failures += 1
        self.reason = result.reason
        end = self._keep(index, result)
        if end >= 0:
            self.nodes[end].failures += 1
        return False

    def try_retreats(self) -> bool:
        """Drive to each retreat configuration, and from there to the tasks."""
        for configuration in retreat_configurations(self.world.robot):
            task = Posture(configuration, speed=RETREAT_SPEED)
            result = self.roll_out(self.nodes[0].q, (task,), RETREAT_SECONDS)
            new = self._keep(0, result)
            if new >= 0 and self.try_goal(new):
                return True
        return False

    def try_paths(self) -> bool:
        """Search a path in the joint space from each node except the start."""
        robot = self.world.robot
        for index, node in list(enumerate(self.nodes))[1:]:
            found = find_path(self.world, self.tasks, node.q, self.options, self.planner.seed)
            if found is not None and len(found.configurations):
                track = resample_path(found.configurations, robot, self.planner.dt)
                self.add(index, track[1:], track[-1])
                return True
        return False

    def extend(self, target: NDArray[np.float64]) -> int:
        """Roll out from the nearest node towards a position; return the new node, or -1."""
        distances = [float(np.linalg.norm(node.position - target)) for node in self.nodes]
        index = int(np.argmin(distances))
        return self._keep(index, self.roll_out(self.nodes[index].q, (Position(target),)))

    def roll_out(
        self, q: NDArray[np.float64], tasks: tuple[Task, ...], longest: float | None = None
    ) -> _Rollout:
        """Simulate the controller from q (n,) until it stops or the time limit passes."""
        self.rollouts += 1
        controller = ApproachController(self.world, tasks, self.options, instant=True)
        configurations = []
        reason = "a roll-out reached its time limit"
        for _ in range(round((longest or self.planner.longest) / self.planner.dt)):
            cycle = controller.step(q)
            if cycle.status not in ("moving", "too_near"):
                reason = cycle.reason
                break
            q = q + self.planner.dt * cycle.velocity
            configurations.append(q)
        return _Rollout(np.array(configurations).reshape(-1, len(q)), reason)

    def path(self, index: int) -> NDArray[np.float64]:
        """Return the configurations (N, n) from the start to a node."""
        pieces = []
        while index > 0:
            pieces.append(self.nodes[index].configurations)
            index = self.nodes[index].parent
        return np.vstack([self.nodes[0].q[None], *reversed(pieces)])

    def _keep(self, parent: int, result: _Rollout) -> int:
        """Add the end of a roll-out unless a node is near; return the new node, or -1."""
        if not len(result.configurations):
            return -1
        q = result.configurations[-1]
        position = self.world.robot.at(q).position
        for node in self.nodes:
            joints = np.linalg.norm(node.q - q)
            if np.linalg.norm(node.position - position) + JOINT_WEIGHT * joints < MIN_STEP:
                return -1
        return self.add(parent, result.configurations, q)
