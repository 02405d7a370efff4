"""Select the next object and the best grasp that the arm can reach."""

from __future__ import annotations

import time
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from eyehand.errors import InputError

from .control_tasks import control_tasks
from .hands import HandModel, ParallelHand
from .hold_quality import plan_hold
from .jaw_plan import jaw_plans
from .jaws import plan_grasps
from .motion import TURN_SPEED, with_speed
from .opposed_grasps import plan_opposed_grasps
from .pick_state import TARGET, TRANSIT_SPEED, PickState, SelectedGrasp
from .planning import GraspOptions, plan_prototypes
from .reachable import is_reachable
from .report import UNREACHABLE
from .scene_validation import REFUSED_WARNINGS

if TYPE_CHECKING:
    from collections.abc import Collection, Iterable, Iterator, Sequence

    from eyehand.control import CollisionWorld
    from eyehand.perception import Scene, SceneObject

    from .cell import Cell
    from .failed_grasps import FailedGrasps, FailedObject
    from .jaws import JawOptions
    from .plan import GraspPlan

    Candidate = tuple[float, SceneObject, GraspPlan]
    Candidates = list[Candidate]

    Worlds = dict[tuple[int, float, str], CollisionWorld]

LOADED_WEIGHT = 0.3
"""Weight of the score of an object that another one rests on. Upper objects go first, but two
objects that rest on each other must both stay possible."""
REPEATED_WEIGHT = 0.4
"""Weight of the score of a grasp whose kind already failed on the object. Other kinds go first."""
WARNED_WEIGHT = {"cut_by_image": 0.3, "may_be_several": 0.5, "may_be_background": 0.3}
"""Weight of the score of an object with a warning of this kind. Its solid may be wrong, so that
objects without a warning go first. A later image may show it better."""

MANY_GRASPS = 24
"""Number of grasps of jaws on each object that are tried if the arm reaches none of the best. Those
may have one and the same approach."""
MIN_HOLD = 0.5
"""Minimum probability that a grasp holds by contact mechanics. Less probable ones go last, also
after other grasps of objects with a failure. The score does not see round ends: fingers that close
along a lying bulb slip off its tip."""


@dataclass(frozen=True)
class GraspSelection:
    """The selected grasp, or the reasons why there is none."""

    grasp: SelectedGrasp | None
    """The grasp to execute."""
    skipped: tuple[str, ...]
    """Objects that were skipped, each with the reason."""
    plan_ms: float = 0.0
    """Computing time of the selection, successful or not, ms."""


def select_grasp(
    cell: Cell,
    scene: Scene,
    failed: FailedGrasps | None = None,
    options: GraspOptions | None = None,
    perceive_ms: float = 0.0,
    spent_ms: float = 0.0,
    labels: Collection[int] | None = None,
) -> GraspSelection:
    """Select the grasp with the best score that the arm can reach.

    Nothing is selected in a scene with a warning that forbids motion, as in `clear_table`. The arm
    avoids all objects of the scene. To pick a chosen one, name its label; a scene without
    the others would lead the hand through them.

    Parameters
    ----------
    cell
        The robot at rest.
    scene
        Perceived scene.
    failed
        Failed grasps, which are not tried again. An object with `PickOptions.max_attempts` of them
        is skipped. Default: none.
    options
        Options of grasp planning.
    perceive_ms
        Computing time of perception, ms, for the report.
    spent_ms
        Computing time of earlier selections without a result, ms. It is added.
    labels
        Labels (`SceneObject.label`) of the objects that may be picked. Default: all.

    Raises
    ------
    InputError
        If the scene has no object with one of the labels.
    """
    began = time.perf_counter()
    items = _chosen(scene, labels)
    cell.enter("select")
    warned = _warned_weights(scene)
    skipped: dict[int, str] = {}
    tried = {} if failed is None else failed.recognise(scene)
    open_items: list[SceneObject] = []
    for item in items:
        attempts = len(tried[item.label].grasps) if item.label in tried else 0
        if attempts >= cell.options.max_attempts:
            skipped[item.label] = f"skipped after {attempts} attempts"
        else:
            open_items.append(item)
    worlds: Worlds = {}
    stages = _stages(cell, scene, open_items, tried, options, skipped)
    ordered = (one for planned in stages for one in _weighed(planned, tried, warned))
    for _, item, plan in _probable_first(ordered, cell.robot.hand):
        grasp = SelectedGrasp(scene, item, plan, perceive_ms)
        reason = check_reachability(cell, PickState(grasp), worlds)
        if not reason:
            plan_ms = spent_ms + 1e3 * (time.perf_counter() - began)
            firm = item.label in tried and tried[item.label].slipped
            grasp = SelectedGrasp(scene, item, plan, perceive_ms, plan_ms, firm)
            return GraspSelection(grasp, _by_label(skipped), plan_ms)
        skipped[item.label] = reason
    return GraspSelection(None, _by_label(skipped), spent_ms + 1e3 * (time.perf_counter() - began))


def _chosen(scene: Scene, labels: Collection[int] | None) -> Sequence[SceneObject]:
    """Return the objects with labels, or all objects; raise an `InputError` for unknown labels."""
    if labels is None:
        return scene.objects
    unknown = set(labels) - {item.label for item in scene.objects}
    if unknown:
        solids = [(item.label, item.fit.superquadric) for item in scene.objects]
        known = [f"{label} ({solid.kind if solid else 'no solid'})" for label, solid in solids]
        raise InputError(
            f"labels: the scene has no object {', '.join(map(str, sorted(unknown)))}; "
            f"its objects are {', '.join(known) or 'none'}"
        )
    return [item for item in scene.objects if item.label in labels]


def _stages(
    cell: Cell,
    scene: Scene,
    items: Sequence[SceneObject],
    tried: dict[int, FailedObject],
    options: GraspOptions | None,
    skipped: dict[int, str],
) -> Iterator[Candidates]:
    """Yield candidates in groups. A later group is only planned if none before is reached.

    First come the usual grasps of objects without a failure, then those of the others with the
    grasps of opposed fingers on objects without a usual one, and last those on all objects.
    """
    hand = cell.robot.hand
    if isinstance(hand, ParallelHand):
        jaws = cell.options.jaws
        yield _jaw_candidates(hand, scene, items, jaws, skipped)
        more = replace(jaws, per_object=max(jaws.per_object, MANY_GRASPS))
        rest: dict[int, str] = {}
        yield _jaw_candidates(hand, scene, items, more, rest, jaws.per_object)
        return
    doubt = next((one.message for one in scene.warnings if one.kind in REFUSED_WARNINGS), "")
    if doubt:
        skipped.update((item.label, f"the scene is not reliable: {doubt}") for item in items)
        return
    usual = _finger_candidates(hand, scene, items, options, skipped)
    planned = {item.label for _, item, _ in usual}
    yield [one for one in usual if one[1].label not in tried]
    again = [one for one in usual if one[1].label in tried]
    yield again + _opposed_candidates(hand, scene, {item.label for item in items} - planned)
    yield _opposed_candidates(hand, scene, planned)


def _weighed(
    planned: Candidates, tried: dict[int, FailedObject], warned: dict[int, float]
) -> Candidates:
    """Return candidates in the order in which they are tried, without those that failed before."""
    candidates: Candidates = []
    for score, item, plan in planned:
        entry = tried.get(item.label)
        if entry is not None and entry.repeats(plan, item):
            continue
        repeated = entry is not None and plan.name in {grasp.name for grasp in entry.grasps}
        weight = warned.get(item.label, 1.0) * (REPEATED_WEIGHT if repeated else 1.0)
        candidates.append((weight * score, item, plan))
    # Objects without a failure go first: their grasp may free the others.
    candidates.sort(key=lambda candidate: (candidate[1].label in tried, -candidate[0]))
    return candidates


def _probable_first(
    candidates: Iterable[Candidate], hand: HandModel | ParallelHand
) -> Iterator[Candidate]:
    """Yield the candidates in their order, but grasps that will probably not hold at the end.

    Jaws have their own prediction, which is part of their score.
    """
    improbable: Candidates = []
    for candidate in candidates:
        _, item, plan = candidate
        solid = item.fit.superquadric
        if (
            solid is None
            or isinstance(hand, ParallelHand)
            or plan.tip_depth is None
            or plan_hold(plan, solid, hand) >= MIN_HOLD
        ):
            yield candidate
        else:
            improbable.append(candidate)
    yield from improbable


def _finger_candidates(
    hand: HandModel,
    scene: Scene,
    items: Sequence[SceneObject],
    options: GraspOptions | None,
    skipped: dict[int, str],
) -> Candidates:
    """Return score, object and plan of each grasp of a hand with fingers; note refusals."""
    loaded = {item.rests_on for item in scene.objects}
    found: Candidates = []
    for item in items:
        others = [other for other in scene.objects if other is not item]
        weight = LOADED_WEIGHT if item.label in loaded else 1.0
        for plan in plan_prototypes(
            item,
            scene.support,
            neighbours=others,
            background=scene.background,
            hand=hand,
            options=options,
        ):
            if plan:
                found.append((weight * plan.score.total, item, plan))
            else:
                skipped[item.label] = plan.reason
    return found


def _opposed_candidates(hand: HandModel, scene: Scene, labels: Collection[int]) -> Candidates:
    """Return score, object and plan of each grasp of opposed fingers on objects with labels."""
    if not labels:
        return []
    loaded = {item.rests_on for item in scene.objects}
    return [
        (plan.score.total * (LOADED_WEIGHT if item.label in loaded else 1.0), item, plan)
        for item, plan in plan_opposed_grasps(scene, hand, labels)
    ]


def _jaw_candidates(
    hand: ParallelHand,
    scene: Scene,
    items: Sequence[SceneObject],
    options: JawOptions,
    skipped: dict[int, str],
    known: int = 0,
) -> Candidates:
    """Return score, object and plan of each safe grasp of jaws; note refusals.

    The best ``known`` grasps of each object are left out.
    """
    grasps = plan_grasps(scene, hand, options)
    up = np.array([0.0, 0.0, 1.0]) if scene.support is None else scene.support.normal
    found: Candidates = []
    for item in items:
        mine = [grasp for grasp in grasps if grasp.object_label == item.label]
        safe = [grasp for grasp in mine if grasp.safe]
        if not safe:
            reasons = [reason for grasp in mine for reason in grasp.forbidden_by]
            reasons = reasons or list(grasps.rejected.get(item.label, {}))
            skipped[item.label] = f"no safe grasp: {', '.join(dict.fromkeys(reasons))}"
        for grasp in (one for one in mine[known:] if one.safe):
            found += [(plan.score.total, item, plan) for plan in jaw_plans(hand, grasp, item, up)]
    return found


def check_reachability(cell: Cell, state: PickState, worlds: Worlds) -> str:
    """Return the reason why the arm cannot reach a grasp; empty if it can.

    ``worlds`` caches the collision world of each object and hand shape, because building one takes
    longer than the check itself.
    """
    hand, q = cell.robot.hand, cell.reading.q
    speed = cell.options.speed
    pre_grasp = with_speed(
        control_tasks(state.plan, hand, state.retreat(cell)),
        speed * TRANSIT_SPEED,
        speed * TURN_SPEED,
    )
    key = (state.grasp.target.label, round(state.plan.opening, 3), state.prototype)
    if key not in worlds:
        worlds[key] = state.world(cell, "obstacle")
    world = worlds[key]
    ahead = is_reachable(world, [pre_grasp], q, state.far_options(cell))
    if not ahead and not state.near_goal(cell, pre_grasp, ahead.q):
        return f"{UNREACHABLE} the pre-grasp of a {state.plan.name}: {ahead.reason}"
    grasp = control_tasks(state.plan, hand, 0.0)
    bodies = [one for one in world.obstacles if one.name.startswith(TARGET)]
    for body in bodies:
        world.remove(body.name)
    ahead = is_reachable(world, [grasp], ahead.q, state.near_options(cell))
    for body in bodies:
        world.add(body)
    if ahead or state.near_goal(cell, grasp, ahead.q):
        return ""
    return f"{UNREACHABLE} a {state.plan.name}: {ahead.reason}"


def _warned_weights(scene: Scene) -> dict[int, float]:
    """Return label → weight of the objects that a warning is about."""
    weights: dict[int, float] = {}
    for warning in scene.warnings:
        if warning.label is not None:
            weight = WARNED_WEIGHT.get(warning.kind, 1.0)
            weights[warning.label] = weight * weights.get(warning.label, 1.0)
    return weights


def _by_label(skipped: dict[int, str]) -> tuple[str, ...]:
    return tuple(f"object {label}: {reason}" for label, reason in skipped.items())
