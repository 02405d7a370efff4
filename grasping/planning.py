"""Plan the grasps of an object: candidates of all prototypes, ranked by score."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, get_args

import numpy as np

from eyehand.errors import InputError

from .approach_tasks import approach_tasks
from .candidates import GraspCandidate, low_clearance_candidates, usual_candidates
from .extents import measure_extents
from .grasp_geometry import grasp_geometries
from .grasp_scoring import GraspContext
from .hand_clearance import neighbour_points
from .hands import HandModel, nominal_hand
from .plan import GraspPlan, Score
from .prototypes import GraspPurpose, mass_range

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from eyehand.perception import SceneObject, SupportPlane

MIN_VISIBLE = 0.25
"""Minimum visible share of an object's outline for its fit to be trusted. With a lower value more
objects are grasped, but a larger share of the grasps fails."""


@dataclass(frozen=True)
class GraspOptions:
    """Options of :func:`plan_prototypes`."""

    purpose: GraspPurpose = "lift"
    """Purpose of the grasp."""
    push: bool = False
    """Whether fingers may push neighbours aside. It also adds grasps that need less free space;
    they are otherwise planned only if no other grasp is possible."""


def plan_prototypes(
    scene_object: SceneObject,
    support: SupportPlane | None = None,
    *,
    neighbours: Sequence[SceneObject] = (),
    background: NDArray[np.float64] | None = None,
    hand: HandModel | None = None,
    up: NDArray[np.float64] | None = None,
    options: GraspOptions | None = None,
) -> tuple[GraspPlan, ...]:
    """Plan all possible grasps of an object, the best first.

    Parameters
    ----------
    scene_object
        Object with its fit.
    support
        Support plane in the same frame; its normal is up.
    neighbours
        Other objects of the scene, which the fingers must avoid. They may include the object
        itself, which is ignored.
    background
        Readings (K, 3) of what belongs to no object, `Scene.background`, m. The fingers must avoid
        them too.
    hand
        Model of the hand; None for `nominal_hand`.
    up
        Up direction (3,) if there is no support plane; None for z.
    options
        Options of planning; None for the defaults.

    Returns
    -------
    tuple of GraspPlan
        At least one plan. If no grasp is possible, the only element is a refusal: `bool(plan)` is
        false, and `plan.reason` is the reason. The order of plans of equal score is fixed.

    Raises
    ------
    InputError
        If the purpose is unknown, or `up` is not 3 finite numbers or has length 0.
    """
    options = options or GraspOptions()
    if options.purpose not in get_args(GraspPurpose):
        raise InputError(
            f"purpose must be one of {', '.join(get_args(GraspPurpose))}, got {options.purpose!r}"
        )
    solid = scene_object.fit.superquadric
    if solid is None or not scene_object.fit:
        return (_refusal(f"no solid was fitted: {scene_object.fit.reason}"),)
    if scene_object.visible_share < MIN_VISIBLE:
        return (
            _refusal(
                f"only {scene_object.visible_share:.0%} of the outline is visible, "
                f"at least {MIN_VISIBLE:.0%} are needed"
            ),
        )
    if support is not None:
        up = support.normal
    up = np.array([0.0, 0.0, 1.0]) if up is None else np.asarray(up, dtype=np.float64)
    if up.shape != (3,) or not np.isfinite(up).all() or not np.linalg.norm(up) > 0:
        raise InputError(f"up must be 3 finite numbers, not all 0, got {up.tolist()}")
    hand = hand or nominal_hand()
    extents = measure_extents(solid, up)
    mass = mass_range(sum(part.volume for part in scene_object.fit.parts or (solid,)))
    context = GraspContext(
        hand=hand,
        solid=solid,
        label=scene_object.label,
        neighbours=neighbour_points(scene_object, neighbours, hand, background),
        mass=mass[1],
        visible=scene_object.visible_share,
        narrowest=extents.width,
        purpose=options.purpose,
    )
    geometries = grasp_geometries(scene_object, solid, extents, support)
    candidates = tuple(usual_candidates(geometries, context))
    possible = _ranked([each for each in candidates if each.evaluation.total > 0.0])
    if options.push or (not possible and len(context.neighbours.points)):
        more = low_clearance_candidates(geometries, solid, context, push=options.push)
        possible = _ranked([*possible, *more])
    if not possible:
        rejected = _rejected(candidates, "", 0.0)
        reasons = "; ".join(f"{name}: {refusal}" for name, refusal in rejected.items())
        return (_refusal(f"no prototype is suitable ({reasons})", rejected, mass),)
    return tuple(_plan(each, candidates, mass, may_push=options.push) for each in possible)


def select_prototype(
    scene_object: SceneObject,
    support: SupportPlane | None = None,
    *,
    neighbours: Sequence[SceneObject] = (),
    background: NDArray[np.float64] | None = None,
    hand: HandModel | None = None,
    up: NDArray[np.float64] | None = None,
    options: GraspOptions | None = None,
) -> GraspPlan:
    """Return the best plan of :func:`plan_prototypes`, or the refusal."""
    return plan_prototypes(
        scene_object,
        support,
        neighbours=neighbours,
        background=background,
        hand=hand,
        up=up,
        options=options,
    )[0]


def _ranked(candidates: Sequence[GraspCandidate]) -> list[GraspCandidate]:
    return sorted(candidates, key=lambda candidate: -candidate.evaluation.total)


def _plan(
    selected: GraspCandidate,
    candidates: Sequence[GraspCandidate],
    mass: tuple[float, float, float],
    *,
    may_push: bool,
) -> GraspPlan:
    geometry, placement = selected.geometry, selected.placement
    return GraspPlan(
        prototype=selected.prototype,
        approach=geometry.approach,
        opening=selected.opening,
        closing=geometry.closing,
        palm=geometry.palm,
        tasks=approach_tasks(geometry, placement),
        score=Score(selected.evaluation.total, selected.evaluation.terms),
        rejected=_rejected(candidates, selected.name, selected.evaluation.total),
        mass=mass,
        reason=(
            f"{geometry.kind} {geometry.width * 1e3:.0f} x {geometry.length * 1e3:.0f} mm, "
            f"{geometry.height * 1e3:.0f} mm high: "
            f"{selected.prototype} from the {geometry.approach}"
        ),
        geometry=geometry,
        standoff=placement.standoff,
        palm_gap=placement.standoff - geometry.half_depth,
        tip_depth=selected.depth,
        pushed_label=selected.pushed_label,
        fingers=selected.evaluation.fingers,
        may_push=may_push,
    )


def _rejected(candidates: Sequence[GraspCandidate], selected: str, score: float) -> dict[str, str]:
    """Return, for each other kind of grasp, why its best candidate was rejected."""
    best: dict[str, GraspCandidate] = {}
    for candidate in candidates:
        if candidate.name == selected:
            continue
        current = best.get(candidate.name)
        if current is None or candidate.evaluation.total > current.evaluation.total:
            best[candidate.name] = candidate
    return {
        name: each.evaluation.refusal or f"score {each.evaluation.total:.2f}, selected {score:.2f}"
        for name, each in best.items()
    }


def _refusal(
    reason: str,
    rejected: dict[str, str] | None = None,
    mass: tuple[float, float, float] = (0.0, 0.0, 0.0),
) -> GraspPlan:
    return GraspPlan(
        prototype=None,
        approach=None,
        opening=0.0,
        closing=np.zeros(3),
        palm=np.zeros(3),
        tasks=(),
        score=Score(0.0, {}),
        rejected=rejected or {},
        mass=mass,
        reason=reason,
    )
