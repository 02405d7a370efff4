"""Plan a path in the joint space: inverse kinematics from several seeds, two trees, shortcuts."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .approach import counted
from .collision_world import CollisionWorld
from .configuration_space import Motion, Space, clearance_at
from .inverse_kinematics import Solutions, solve_tasks
from .joint_path import SPEED_FRACTION, JointPath
from .mujoco_binding import address, mujoco
from .options import ControlOptions
from .proximity_tables import World
from .retreat import retreat_configurations
from .tasks.registry import pack_tasks
from .tasks.task import DEFAULT_LINEAR_SPEED, Task
from .tree_kernels import connect, shorten

SEEDS = 40
"""Number of seeds of the inverse kinematics."""
GOALS = 8
"""Number of goal configurations of the first searches, those nearest to the start."""
PATHS = 10
"""Number of searches, each with another seed. The fastest of their paths is taken."""
ITERATIONS = 600
"""Maximum number of iterations of a search."""
LAST_ITERATIONS = 4000
"""Maximum number of iterations of the last search, with all goal configurations. The nearest ones
may all lie behind the same obstacle."""
SHORTCUTS = 120
"""Number of attempted shortcuts per path."""
EXTRA_CLEARANCE = 0.008
"""Distance beyond the margin that a path keeps away from its ends, m. With less, the velocity
dampers slow the arm down; with more, narrow gaps are closed."""
END_CLEARANCE = 5e-4
"""Distance beyond the margin at the goal, m."""


@dataclass(frozen=True, eq=False)
class PlannedPath:
    """A path, or why there is none."""

    configurations: NDArray[np.float64]
    """Corners (N, n) from the start to a configuration that reaches the tasks; none if no rows."""
    seconds: float
    """Time of the motion along it, s."""
    reason: str
    """Why no path was found; empty otherwise."""
    error: float
    """Smallest error of the tasks that the joints can reach without obstacles, m or rad."""
    nearest: NDArray[np.float64]
    """Configuration (n,) with this error."""
    nodes: int
    """Number of nodes of all trees."""
    computed: float
    """Time the search took, s."""

    def as_joint_path(self) -> JointPath:
        """Return the path with one configuration at each corner."""
        found = len(self.configurations) > 0
        corners = self.configurations if found else self.nearest[None]
        dt = self.seconds / max(len(corners) - 1, 1) if found else 0.0
        return JointPath(found, corners, dt, self.reason, 0, self.nodes, self.computed)


def solutions(
    world: CollisionWorld, tasks: Sequence[Task], q: NDArray[np.float64], seed: int = 0
) -> Solutions | None:
    """Return configurations for the tasks from several seeds; None for tasks without a kernel."""
    robot, tables = world.robot, world.tables
    packed = pack_tasks([tasks[k] for k in counted(tasks)], robot.n)
    if packed is None:
        return None
    rng = np.random.default_rng(seed)
    low, high = drawn_range(world)
    seeds = [q, *retreat_configurations(robot)]
    seeds += list(rng.uniform(low, high, (SEEDS - len(seeds), robot.n)))
    data = tables.data
    views = (address(tables.model), address(data), data.qpos, data.xanchor, data.xaxis)
    return solve_tasks(
        np.array(seeds), packed, robot.limits(), frame_views(world), (*views, tables.joints)
    )


def find_path(
    world: CollisionWorld,
    tasks: Sequence[Task],
    q: NDArray[np.float64],
    options: ControlOptions,
    seed: int = 0,
) -> PlannedPath | None:
    """Return a path from q (n,) to the tasks; None if a task has no kernel."""
    began = time.perf_counter()
    found = solutions(world, tasks, q, seed)
    if found is None:
        return None
    best = int(np.argmin(found.errors))
    error, nearest = float(found.errors[best]), found.configurations[best]

    def result(path: NDArray[np.float64], seconds: float, reason: str, nodes: int) -> PlannedPath:
        computed = time.perf_counter() - began
        return PlannedPath(path, seconds, reason, error, nearest, nodes, computed)

    nothing = np.zeros((0, len(q)))
    space = make_space(world)
    low, high = drawn_range(world)
    end = options.margin + END_CLEARANCE
    reaching = _reaching(found, world, options)
    if not len(reaching):
        return result(nothing, np.inf, f"out of reach by {error:.3g}", 0)
    clear = [one for one in reaching if clearance_at(one, space, end) >= end]
    if not clear:
        return result(nothing, np.inf, "obstacles are too near at every goal configuration", 0)
    levers = joint_levers(world)
    goals = sorted(clear, key=lambda one: float(np.linalg.norm(levers * (one - q))))
    end = min(end, 0.95 * clearance_at(q, space, end))
    rng = np.random.default_rng(seed)
    fastest, seconds, nodes = nothing, np.inf, 0
    attempts = [(extra, GOALS, ITERATIONS) for extra in (EXTRA_CLEARANCE, END_CLEARANCE)]
    for extra, used, iterations in [*attempts, (END_CLEARANCE, SEEDS, LAST_ITERATIONS)]:
        motion = Motion(
            options.margin + extra, end, np.array([q, *goals[:used]]), levers,
            SPEED_FRACTION * world.robot.speed, DEFAULT_LINEAR_SPEED,
        )  # fmt: skip
        for _ in range(PATHS):
            path, count = connect(np.column_stack([low, high]), space, motion, iterations, rng)
            nodes += count
            if not len(path):
                break
            path, cost = shorten(path, space, motion, SHORTCUTS, rng)
            if cost < seconds:
                fastest, seconds = path, float(cost)
        if len(fastest):
            return result(fastest, seconds, "", nodes)
    return result(nothing, np.inf, "the trees did not meet", nodes)


def _reaching(
    found: Solutions, world: CollisionWorld, options: ControlOptions
) -> NDArray[np.float64]:
    """Return the solutions (S, n) that reach the tasks and keep away from the joint limits."""
    robot, margin = world.robot, options.limit_margin
    inside = np.all(
        (found.configurations >= robot.lower + margin)
        & (found.configurations <= robot.upper - margin),
        axis=1,
    )
    return found.configurations[(found.errors <= 0.5 * options.tolerance) & inside]


def drawn_range(world: CollisionWorld) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the range (n,), (n,) of random configurations; a turn where there are no limits."""
    robot = world.robot
    low = np.where(np.isfinite(robot.lower), robot.lower, robot.home - np.pi)
    high = np.where(np.isfinite(robot.upper), robot.upper, robot.home + np.pi)
    return low, high


def joint_levers(world: CollisionWorld) -> NDArray[np.float64]:
    """Return how far each joint moves the robot's parts, m/rad (n,): an upper estimate.

    It is the distance along the chain from the joint to the frame, and a hand's length beyond.
    """
    robot = world.robot
    state = robot.at(robot.home)
    anchors = robot.data.xanchor[robot.joints]
    points = np.vstack([anchors, state.position])
    lengths = np.linalg.norm(np.diff(points, axis=0), axis=1)
    reach = np.cumsum(lengths[::-1])[::-1] + 0.1
    return np.where(robot.hinge, reach, 1.0)


def frame_views(world: CollisionWorld) -> tuple[NDArray[np.float64], ...]:
    """Return views of the frame's origin (3,) and axes (9,), and the joints that move it (n,)."""
    robot, tables = world.robot, world.tables
    data = tables.data
    site = mujoco.mj_name2id(tables.model, mujoco.mjtObj.mjOBJ_SITE, robot.frame)
    moves = np.ascontiguousarray(robot.moves[robot.frame_body])
    if site >= 0:
        return data.site_xpos[site], data.site_xmat[site], moves
    return data.xpos[robot.frame_body], data.xmat[robot.frame_body], moves


def make_space(world: CollisionWorld) -> Space:
    """Return the world for the kernels of :mod:`configuration_space`."""
    tables = world.tables
    model, data = tables.model, tables.data
    inner = World(
        address(model), address(data), data.geom_xpos, data.geom_xmat,
        tables.shapes, tables.cut_off,
    )  # fmt: skip
    return Space(
        inner, data.qpos, data.xpos, data.xmat, tables.joints, tables.pairs, tables.held,
        frame_views(world)[0],
    )  # fmt: skip
