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
from .nominal_hand import nominal_hand
from .plan import GraspPlan, Score
from .prototypes import GraspPurpose, mass_range

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from eyehand.perception import SceneObject, SupportPlane

    from .hand_model import HandModel


@dataclass(frozen=True)
class GraspOptions:
    """Options of :func:`plan_grasps`."""

    purpose: GraspPurpose = "lift"
    """Purpose of the grasp."""
    min_visible: float = 0.25
    """Minimum visible share of an object's outline for its fit to be trusted, in [0, 1]. Lower
    grasps more objects, but misses more of them."""
    push: bool = False
    """Whether fingers may push neighbours aside. It also adds grasps that need less free space;
    they are otherwise planned only if no other grasp is possible."""


def plan_grasps(
    scene_object: SceneObject,
    support: SupportPlane | None = None,
    *,
    neighbours: Sequence[SceneObject] = (),
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
        Other objects of the scene, which the fingers must avoid. The object itself may be among
        them.
    hand
        The hand; None for `nominal_hand`.
    up
        Up direction (3,) without a support plane; default z.
    options
        Purpose, and how much to trust the fit.

    Returns
    -------
    tuple of GraspPlan
        At least one plan. If no grasp is possible it is a single refusal, which is false in a
        condition and holds the reason. Plans of equal score have a fixed order.

    Raises
    ------
    InputError
        If the purpose is unknown, or up is not a direction.
    """
    options = options or GraspOptions()
    if options.purpose not in get_args(GraspPurpose):
        raise InputError(
            f"purpose must be one of {', '.join(get_args(GraspPurpose))}, got {options.purpose!r}"
        )
    solid = scene_object.fit.superquadric
    if solid is None or not scene_object.fit:
        return (_refusal(f"no solid was fitted: {scene_object.fit.reason}"),)
    if scene_object.visible_share < options.min_visible:
        return (
            _refusal(
                f"only {scene_object.visible_share:.0%} of the outline is visible, "
                f"at least {options.min_visible:.0%} are needed"
            ),
        )
    if support is not None:
        up = support.normal
    up = np.array([0.0, 0.0, 1.0]) if up is None else np.asarray(up, dtype=np.float64)
    if up.shape != (3,) or not np.isfinite(up).all() or not np.linalg.norm(up) > 0:
        raise InputError(f"up must be 3 finite numbers, not all 0, got {up.tolist()}")
    hand = hand or nominal_hand()
    extents = measure_extents(solid, up)
    mass = mass_range(solid.volume)
    context = GraspContext(
        hand=hand,
        neighbours=neighbour_points(scene_object, neighbours, hand),
        mass=mass[1],
        visible=scene_object.visible_share,
        narrowest=extents.width,
        purpose=options.purpose,
    )
    geometries = grasp_geometries(scene_object, solid, extents, support)
    found = tuple(usual_candidates(geometries, context))
    possible = _ranked([one for one in found if one.evaluation.total > 0.0])
    if options.push or (not possible and len(context.neighbours.points)):
        more = low_clearance_candidates(geometries, solid, context, push=options.push)
        possible = _ranked([*possible, *more])
    if not possible:
        rejected = _rejected(found, "", 0.0)
        reasons = "; ".join(f"{name}: {refusal}" for name, refusal in rejected.items())
        return (_refusal(f"no prototype suits ({reasons})", rejected, mass),)
    return tuple(_plan(one, found, mass, may_push=options.push) for one in possible)


def select_prototype(
    scene_object: SceneObject,
    support: SupportPlane | None = None,
    *,
    neighbours: Sequence[SceneObject] = (),
    hand: HandModel | None = None,
    up: NDArray[np.float64] | None = None,
    options: GraspOptions | None = None,
) -> GraspPlan:
    """Return the best plan of :func:`plan_grasps`, or the refusal."""
    return plan_grasps(
        scene_object, support, neighbours=neighbours, hand=hand, up=up, options=options
    )[0]


def _ranked(candidates: Sequence[GraspCandidate]) -> list[GraspCandidate]:
    return sorted(candidates, key=lambda one: -one.evaluation.total)


def _plan(
    one: GraspCandidate,
    found: Sequence[GraspCandidate],
    mass: tuple[float, float, float],
    *,
    may_push: bool,
) -> GraspPlan:
    geometry, placement = one.geometry, one.placement
    return GraspPlan(
        prototype=one.prototype,
        approach=geometry.approach,
        opening=one.opening,
        closing=geometry.closing,
        palm=geometry.palm,
        tasks=approach_tasks(geometry, placement),
        score=Score(one.evaluation.total, one.evaluation.terms),
        rejected=_rejected(found, one.name, one.evaluation.total),
        mass=mass,
        reason=(
            f"{geometry.kind} {geometry.width * 1e3:.0f} x {geometry.length * 1e3:.0f} mm, "
            f"{geometry.height * 1e3:.0f} mm high: {one.prototype} from the {geometry.approach}"
        ),
        geometry=geometry,
        standoff=placement.standoff,
        palm_gap=placement.standoff - geometry.half_depth,
        tip_depth=one.depth,
        pushed_label=one.pushed_label,
        may_push=may_push,
    )


def _rejected(found: Sequence[GraspCandidate], selected: str, score: float) -> dict[str, str]:
    """Return the reason why each other kind of grasp was rejected, by its best candidate."""
    best: dict[str, GraspCandidate] = {}
    for one in found:
        rival = best.get(one.name)
        if one.name != selected and (
            rival is None or one.evaluation.total > rival.evaluation.total
        ):
            best[one.name] = one
    return {
        name: one.evaluation.refusal or f"score {one.evaluation.total:.2f}, selected {score:.2f}"
        for name, one in best.items()
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
