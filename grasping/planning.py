"""Choose how to grasp an object: prototypes and ways to take hold, ranked, each with its why."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, get_args

import numpy as np

from eyehand.errors import InputError

from .approach_tasks import approach_tasks
from .candidates import Candidate, Circumstances, candidates, crowded_candidates
from .extents import measure
from .grasp_geometry import grips
from .hand_clearance import neighbour_points
from .nominal_hand import nominal_hand
from .palm_placement import GraspDepths
from .plan import GraspPlan, Score
from .prototypes import GraspPurpose, PrototypeLimits, WeightEstimate

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from eyehand.perception import SceneObject, SupportPlane

    from .hand_model import HandModel


@dataclass(frozen=True)
class SelectOptions:
    """Options of :func:`grasp_plans`."""

    limits: PrototypeLimits = field(default_factory=PrototypeLimits)
    """Sizes that the prototypes suit."""
    weight: WeightEstimate = field(default_factory=WeightEstimate)
    """Density range behind the mass estimate."""
    purpose: GraspPurpose = "lift"
    """What happens after the grasp."""
    least_visible: float = 0.25
    """Least visible share of the outline for a fit to be trusted: lower dares more."""
    depths: GraspDepths = field(default_factory=GraspDepths)
    """Where the object is to be in the hand."""
    push: bool = False
    """Whether fingers may push neighbours aside: the last resort of a pile, contact is meant. Adds
    grasps that need less room too, which are otherwise tried only where no other suits."""


def grasp_plans(
    scene_object: SceneObject,
    support: SupportPlane | None = None,
    *,
    neighbours: Sequence[SceneObject] = (),
    hand: HandModel | None = None,
    up: NDArray[np.float64] | None = None,
    options: SelectOptions | None = None,
) -> tuple[GraspPlan, ...]:
    """Give all grasps that suit an object, best first, or one refusal with the reason.

    Parameters
    ----------
    scene_object
        Object with its fit.
    support
        Support plane in the same frame; its normal is up.
    neighbours
        Other objects of the scene (itself among them does no harm): fingers need room.
    hand
        The hand; one of common size when None.
    up
        Up direction (3,) where there is no support plane; default z.
    options
        Limits of the hand, purpose and trust.

    Returns
    -------
    tuple of GraspPlan
        Prototypes from above and from the side, closing over either pair of sides, the thumb on
        either side. Those alike in score come in a fixed order. At least one; that is false in a
        condition when no prototype suits, and ``reason`` says what is in the way.

    Raises
    ------
    InputError
        If the purpose is not one of the known ones, or up is no direction.
    """
    options = options or SelectOptions()
    if options.purpose not in get_args(GraspPurpose):
        raise InputError(
            f"purpose must be one of {', '.join(get_args(GraspPurpose))}, got {options.purpose!r}"
        )
    solid = scene_object.fit.superquadric
    if solid is None or not scene_object.fit:
        return (_refusal(f"no solid was fitted: {scene_object.fit.reason}"),)
    if scene_object.visible_share < options.least_visible:
        return (
            _refusal(
                f"only {scene_object.visible_share:.0%} of the outline is visible, "
                f"at least {options.least_visible:.0%} are needed"
            ),
        )
    if support is not None:
        up = support.normal
    up = np.array([0.0, 0.0, 1.0]) if up is None else np.asarray(up, dtype=np.float64)
    if up.shape != (3,) or not np.isfinite(up).all() or not np.linalg.norm(up) > 0:
        raise InputError(f"up must be 3 finite numbers, not all 0, got {up.tolist()}")
    hand = hand or nominal_hand()
    extents = measure(solid, up)
    mass = options.weight.mass(solid.volume)
    given = Circumstances(
        hand=hand,
        near=neighbour_points(scene_object, neighbours, hand),
        mass=mass[1],
        visible=scene_object.visible_share,
        narrowest=extents.width,
        purpose=options.purpose,
        limits=options.limits,
        depths=options.depths,
    )
    ways = grips(scene_object, solid, extents, support)
    found = tuple(candidates(ways, given))
    suit = sorted(
        (one for one in found if one.judgement.total > 0.0), key=lambda one: -one.judgement.total
    )
    if options.push or (not suit and len(given.near.points)):
        more = crowded_candidates(ways, solid, given, push=options.push)
        suit = sorted((*suit, *more), key=lambda one: -one.judgement.total)
    if not suit:
        lost = _lost(found, "", 0.0)
        why = "; ".join(f"{name}: {refusal}" for name, refusal in lost.items())
        return (_refusal(f"no prototype suits ({why})", lost, mass),)
    return tuple(_plan(one, found, mass, may_push=options.push) for one in suit)


def select_prototype(
    scene_object: SceneObject,
    support: SupportPlane | None = None,
    *,
    neighbours: Sequence[SceneObject] = (),
    hand: HandModel | None = None,
    up: NDArray[np.float64] | None = None,
    options: SelectOptions | None = None,
) -> GraspPlan:
    """Give the first of :func:`grasp_plans`: power, precision or pincer, or the refusal."""
    return grasp_plans(
        scene_object, support, neighbours=neighbours, hand=hand, up=up, options=options
    )[0]


def _plan(
    one: Candidate,
    found: Sequence[Candidate],
    mass: tuple[float, float, float],
    *,
    may_push: bool,
) -> GraspPlan:
    grip, place = one.grip, one.stance
    return GraspPlan(
        prototype=one.prototype,
        approach=grip.approach,
        opening=one.opening,
        closing=grip.closing,
        palm=grip.palm,
        tasks=approach_tasks(grip, place),
        score=Score(one.judgement.total, one.judgement.terms),
        rejected=_lost(found, one.name, one.judgement.total),
        mass=mass,
        reason=(
            f"{grip.kind} {grip.width * 1e3:.0f} x {grip.length * 1e3:.0f} mm, "
            f"{grip.height * 1e3:.0f} mm high: {one.prototype} from the {grip.approach}"
        ),
        grip=grip,
        standoff=place.standoff,
        depth=place.standoff - grip.half_depth,
        depths=one.depths,
        pushes=one.pushes,
        may_push=may_push,
    )


def _lost(found: Sequence[Candidate], chosen: str, score: float) -> dict[str, str]:
    """Why each kind of grasp lost against a chosen one, by the best of its kind."""
    best: dict[str, Candidate] = {}
    for one in found:
        rival = best.get(one.name)
        if one.name != chosen and (rival is None or one.judgement.total > rival.judgement.total):
            best[one.name] = one
    return {
        name: one.judgement.refusal or f"score {one.judgement.total:.2f} beside {score:.2f}"
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
