"""Choose the grasp prototype for an object, and say why the others lost."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, get_args

import numpy as np

from eyehand.errors import InputError

from .measure import Extents, measure
from .plan import GraspPlan, Score
from .prototypes import Approach, GraspTask, Prototype, PrototypeLimits, WeightEstimate
from .symmetry import approach_tasks, palm_direction

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from eyehand.perception import SceneObject, Superquadric, SupportPlane

TASK_PREFERENCE: dict[GraspTask, dict[Prototype, float]] = {
    "lift": {"power": 1.0, "precision": 0.9, "pincer": 0.9},
    "move": {"power": 1.0, "precision": 0.85, "pincer": 0.8},
    "hand-over": {"power": 0.7, "precision": 1.0, "pincer": 0.9},
    "use": {"power": 1.0, "precision": 0.8, "pincer": 0.6},
}
"""How well each prototype serves what follows: carrying wants the whole hand, handing over wants
a part of the object left free."""


PRECISION_FALLBACK = 0.7
"""Precision holds almost everything, but less surely than what suits the size."""


@dataclass(frozen=True)
class SelectOptions:
    """Options of :func:`select_prototype`."""

    limits: PrototypeLimits = field(default_factory=PrototypeLimits)
    """Sizes that the prototypes suit."""
    weight: WeightEstimate = field(default_factory=WeightEstimate)
    """Density range behind the mass estimate."""
    task: GraspTask = "lift"
    """What happens after the grasp."""
    least_visible: float = 0.25
    """Least visible share of the outline for a fit to be trusted: lower dares more."""
    neighbour_gap: float = 0.025
    """Free space that a finger needs beside the object, m."""


@dataclass(frozen=True)
class _Candidate:
    prototype: Prototype
    approach: Approach
    refusal: str
    terms: dict[str, float]

    @property
    def total(self) -> float:
        return float(np.prod(list(self.terms.values()))) if not self.refusal else 0.0


def select_prototype(
    scene_object: SceneObject,
    support: SupportPlane | None = None,
    *,
    neighbours: Sequence[SceneObject] = (),
    up: NDArray[np.float64] | None = None,
    options: SelectOptions | None = None,
) -> GraspPlan:
    """Choose power, precision or pincer for an object, or refuse with the reason.

    Parameters
    ----------
    scene_object
        Object with its fit.
    support
        Support plane in the same frame; its normal is up.
    neighbours
        Other objects of the scene; those closer than a finger's width rule out the side.
    up
        Up direction (3,) where there is no support plane; default z.
    options
        Limits of the hand, task and trust.

    Returns
    -------
    GraspPlan
        False in a condition when no prototype suits; ``reason`` says what is in the way.

    Raises
    ------
    InputError
        If the task is not one of the known ones, or up is no direction.
    """
    options = options or SelectOptions()
    if options.task not in get_args(GraspTask):
        raise InputError(
            f"task must be one of {', '.join(get_args(GraspTask))}, got {options.task!r}"
        )
    solid = scene_object.fit.superquadric
    if solid is None or not scene_object.fit:
        return _refusal(f"no solid was fitted: {scene_object.fit.reason}")
    if scene_object.visible_share < options.least_visible:
        return _refusal(
            f"only {scene_object.visible_share:.0%} of the outline is visible, "
            f"at least {options.least_visible:.0%} are needed"
        )
    if support is not None:
        up = support.normal
    up = np.array([0.0, 0.0, 1.0]) if up is None else np.asarray(up, dtype=np.float64)
    if up.shape != (3,) or not np.isfinite(up).all() or not np.linalg.norm(up) > 0:
        raise InputError(f"up must be 3 finite numbers, not all 0, got {up.tolist()}")
    extents = measure(solid, up)
    crowded = _crowded(scene_object, neighbours, extents, options.neighbour_gap)
    mass = options.weight.mass(solid.volume)
    candidates = [
        _pincer(extents, mass[1], options),
        _side_power(extents, crowded, options),
        _top_power(extents, options),
        _precision(extents, mass[1], options),
    ]
    best = max(candidates, key=lambda candidate: candidate.total)
    rejected = {
        f"{c.approach} {c.prototype}": c.refusal or f"score {c.total:.2f} < {best.total:.2f}"
        for c in candidates
        if c is not best
    }
    if best.total <= 0.0:
        rejected[f"{best.approach} {best.prototype}"] = best.refusal
        why = "; ".join(f"{name}: {refusal}" for name, refusal in rejected.items())
        return _refusal(f"no prototype suits ({why})", rejected, mass)
    opening = min(extents.width + options.limits.clearance, options.limits.opening)
    standoff = 0.5 * (extents.width if best.approach == "side" else extents.height)
    return GraspPlan(
        prototype=best.prototype,
        approach=best.approach,
        opening=opening,
        closing=extents.closing,
        palm=palm_direction(extents, best.approach),
        tasks=approach_tasks(solid, extents, best.approach, standoff),
        score=Score(best.total, best.terms),
        rejected=rejected,
        mass=mass,
        reason=_because(best, extents, solid),
    )


def _pincer(extents: Extents, mass: float, options: SelectOptions) -> _Candidate:
    limits = options.limits
    refusal = (
        _above("width", extents.width, limits.pincer_width)
        or _above("length", extents.length, limits.pincer_length)
        or _below("height", extents.height, limits.fingertip_height)
        or (f"mass {mass:.2f} kg > {limits.pincer_mass} kg" if mass > limits.pincer_mass else "")
    )
    return _Candidate(
        "pincer",
        "top",
        refusal,
        {
            "width": _margin(extents.width, 0.0, limits.pincer_width),
            "weight": _ease(mass, limits.pincer_mass),
            "task": TASK_PREFERENCE[options.task]["pincer"],
        },
    )


def _side_power(extents: Extents, crowded: str, options: SelectOptions) -> _Candidate:
    limits = options.limits
    low, high = limits.side_power_width
    slender = extents.height / extents.width
    refusal = (
        _below("height", extents.height, limits.side_power_height)
        or (
            f"height/width {slender:.2f} < {limits.side_power_slenderness}"
            if slender < limits.side_power_slenderness
            else ""
        )
        or _below("width", extents.width, low)
        or _above("width", extents.width, high)
        or crowded
    )
    return _Candidate(
        "power",
        "side",
        refusal,
        {
            "width": _margin(extents.width, low, high),
            "height": _ease(limits.side_power_height, extents.height),
            "task": TASK_PREFERENCE[options.task]["power"],
        },
    )


def _top_power(extents: Extents, options: SelectOptions) -> _Candidate:
    limits = options.limits
    low, high = limits.top_power_width
    refusal = (
        _below("width", extents.width, low)
        or _above("width", extents.width, high)
        or _below("height", extents.height, limits.top_power_height)
    )
    return _Candidate(
        "power",
        "top",
        refusal,
        {
            "width": _margin(extents.width, low, high),
            "height": _ease(limits.top_power_height, extents.height),
            "task": TASK_PREFERENCE[options.task]["power"],
        },
    )


def _precision(extents: Extents, mass: float, options: SelectOptions) -> _Candidate:
    limits = options.limits
    refusal = (
        _above("width", extents.width, limits.precision_width)
        or _below("height", extents.height, limits.fingertip_height)
        or (
            f"mass {mass:.2f} kg > {limits.precision_mass} kg"
            if mass > limits.precision_mass
            else ""
        )
    )
    return _Candidate(
        "precision",
        "top",
        refusal,
        {
            "width": _margin(extents.width, 0.0, limits.precision_width),
            "weight": _ease(mass, limits.precision_mass),
            "task": TASK_PREFERENCE[options.task]["precision"],
            "fallback": PRECISION_FALLBACK,
        },
    )


def _margin(value: float, low: float, high: float) -> float:
    """1 in the middle of a range, 0.5 at its ends: room for errors of the fit."""
    middle, half = 0.5 * (low + high), 0.5 * (high - low)
    return float(max(1.0 - 0.5 * abs(value - middle) / half, 0.0))


def _ease(load: float, limit: float) -> float:
    """1 far below a limit, 0.5 at it."""
    return float(max(1.0 - 0.5 * load / limit, 0.0))


def _above(name: str, value: float, limit: float) -> str:
    return f"{name} {value * 1e3:.0f} mm > {limit * 1e3:.0f} mm" if value > limit else ""


def _below(name: str, value: float, limit: float) -> str:
    return f"{name} {value * 1e3:.0f} mm < {limit * 1e3:.0f} mm" if value < limit else ""


def _crowded(
    scene_object: SceneObject,
    neighbours: Sequence[SceneObject],
    extents: Extents,
    gap: float,
) -> str:
    """Why the side is not free, or an empty string: a neighbour within a finger's width."""
    solid = scene_object.fit.superquadric
    assert solid is not None
    up = extents.up
    low, high = -float(solid.support(-up)), float(solid.support(up))
    for other in neighbours:
        if other.label == scene_object.label or not (other.fit or len(other.points)):
            continue
        bottom, top = -_reach(other, -up), _reach(other, up)
        if top < low + gap or bottom > high:
            continue
        if _separation(solid, other, up) < gap:
            return f"object {other.label} stands closer than {gap * 1e3:.0f} mm"
    return ""


def _separation(solid: Superquadric, other: SceneObject, up: NDArray[np.float64]) -> float:
    """Horizontal gap along the line between the centres of a solid and a neighbour, m."""
    near = other.fit.superquadric if other.fit else None
    centre = near.centre if near is not None else np.median(other.points, axis=0)
    between = centre - solid.centre
    between = between - (between @ up) * up
    length = float(np.linalg.norm(between))
    if length == 0.0:
        return 0.0
    towards = between / length
    return -_reach(other, -towards) - float(solid.support(towards))


def _reach(item: SceneObject, direction: NDArray[np.float64]) -> float:
    """Largest coordinate along a direction of an object's solid, or its points where none fits."""
    solid = item.fit.superquadric
    if solid is not None and item.fit:
        return float(solid.support(direction))
    return float((item.points @ direction).max())


def _because(best: _Candidate, extents: Extents, solid: Superquadric) -> str:
    return (
        f"{solid.kind} {extents.width * 1e3:.0f} x {extents.length * 1e3:.0f} mm, "
        f"{extents.height * 1e3:.0f} mm high: {best.prototype} from the {best.approach}"
    )


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
