"""Which object next, and how: the best grasp of those that the arm can get to."""

from __future__ import annotations

import time
from dataclasses import dataclass
from typing import TYPE_CHECKING, Protocol

import numpy as np

from .control_tasks import control_tasks
from .motion import paced
from .pick_state import TARGET, Choice, Job
from .planning import grasp_plans
from .reachable import is_reachable

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from eyehand.control import CollisionWorld
    from eyehand.perception import Scene, SceneObject

    from .cell import Cell
    from .plan import GraspPlan
    from .planning import SelectOptions

    Worlds = dict[tuple[int, float, str], CollisionWorld]

UNDER_ANOTHER = 0.3
"""Share of its score that an object keeps while another rests on it: what lies on top goes first,
but a pile of two that hold each other must begin somewhere."""

SAME_AGAIN = 0.4
"""Share of its score that a grasp keeps after one of the same name failed on the object: another
way to hold it goes first."""


class Tried(Protocol):
    """What was tried before."""

    def tried(self, place: NDArray[np.float64]) -> set[str]:
        """Ways tried on what stands at a place (3,)."""
        ...


@dataclass(frozen=True)
class Chosen:
    """What to do next, or why nothing."""

    choice: Choice | None
    """The pick to make."""
    left: tuple[str, ...]
    """Objects passed over, each with the reason."""
    plan_ms: float = 0.0
    """Time that choosing took, whether it found something or not."""


def choose(
    cell: Cell,
    scene: Scene,
    memory: Tried,
    select: SelectOptions | None = None,
    perceive_ms: float = 0.0,
    spent_ms: float = 0.0,
) -> Chosen:
    """Choose an object and a grasp that the arm can get to, best score first.

    Parameters
    ----------
    cell
        The robot at rest.
    scene
        What is seen.
    memory
        Ways that failed are not tried again; an object is left alone after ``options.tries``.
    select
        How grasps are scored.
    perceive_ms
        Time that seeing took, to be told on.
    spent_ms
        Time that was spent on choosing before, in vain; it counts.
    """
    began = time.perf_counter()
    cell.enter("choose")
    loaded = {one.rests_on for one in scene.objects}
    left: dict[int, str] = {}
    offers: list[tuple[float, SceneObject, GraspPlan]] = []
    for one in scene.objects:
        tried = memory.tried(one.points.mean(axis=0))
        if len(tried) >= cell.options.tries:
            left[one.label] = f"left alone after {len(tried)} tries"
            continue
        others = [other for other in scene.objects if other is not one]
        plans = grasp_plans(
            one, scene.support, neighbours=others, hand=cell.robot.hand, options=select
        )
        share = UNDER_ANOTHER if one.label in loaded else 1.0
        names = {way.split(" facing")[0] for way in tried}
        for plan in plans:
            if not plan:
                left[one.label] = plan.reason
            elif grasp_key(plan) not in tried:
                again = SAME_AGAIN if plan.name in names else 1.0
                offers.append((again * share * plan.score.total, one, plan))
    offers.sort(key=lambda offer: -offer[0])
    worlds: Worlds = {}
    for _, one, plan in offers:
        choice = Choice(scene, one, plan, perceive_ms)
        why = blocked(cell, Job(choice, 0), worlds)
        if not why:
            plan_ms = spent_ms + 1e3 * (time.perf_counter() - began)
            choice = Choice(scene, one, plan, perceive_ms, plan_ms)
            return Chosen(choice, _told(left), plan_ms)
        left[one.label] = why
    return Chosen(None, _told(left), spent_ms + 1e3 * (time.perf_counter() - began))


def blocked(cell: Cell, job: Job, worlds: Worlds) -> str:
    """Tell why the arm would not get to a grasp; empty when a look ahead gets there.

    Worlds are kept by object and shape of the hand: to measure them costs more than to look ahead.
    """
    hand, q = cell.robot.hand, cell.reading.q
    before = control_tasks(job.plan, hand, job.back(cell))
    options = cell.options
    tasks = paced(before, options.transit_speed, options.transit_turn_speed, options.gain)
    key = (job.choice.target.label, round(job.plan.opening, 3), job.prototype)
    if key not in worlds:
        worlds[key] = job.world(cell, "there")
    world = worlds[key]
    ahead = is_reachable(world, [tasks], q, job.far_options(cell))
    if not ahead and not job.there(cell, tasks, ahead.q):
        return f"no way to before a {job.plan.name}: {ahead.reason}"
    at = control_tasks(job.plan, hand, 0.0)
    itself = next((one for one in world.obstacles if one.name == TARGET), None)
    if itself is not None:
        world.remove(TARGET)
    ahead = is_reachable(world, [at], ahead.q, job.near_options(cell))
    if itself is not None:
        world.add(itself)
    if ahead or job.there(cell, at, ahead.q):
        return ""
    return f"no way to a {job.plan.name}: {ahead.reason}"


def grasp_key(plan: GraspPlan) -> str:
    """Name a way to grasp: the same for the hand turned by half, as that is no other way."""
    closing = plan.closing * np.sign(plan.closing[np.argmax(np.abs(plan.closing))] or 1.0)
    return f"{plan.name} facing {plan.palm.round(1)}, closing {closing.round(1)}"


def _told(left: dict[int, str]) -> tuple[str, ...]:
    return tuple(f"object {label}: {why}" for label, why in left.items())
