"""Memory of failed grasps by object. A failed grasp often moves the object, and may turn it."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from .pick_verification import SAME_OBJECT_DISTANCE, have_same_size

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from eyehand.perception import Scene, SceneObject

    from .plan import GraspPlan

MAX_MOTION = 0.20
"""Maximum distance by which a failed grasp moves an object, m. Boxes that leave the closing hand
were kicked by up to 180 mm."""
SAME_WIDTH_SHARE, SAME_WIDTH = 0.12, 0.004
"""Maximum difference of the widths of one grasp in two scenes, as a share and in m; the larger of
the two counts."""
SAME_COSINE = 0.87
"""Cosine of the maximum angle between the directions of one grasp in two scenes (30°)."""


@dataclass(frozen=True, eq=False)
class FailedGrasp:
    """A grasp that failed, in terms that do not change when the object moves."""

    name: str
    """Approach and prototype."""
    width: float
    """Width of the object along the closing direction, m."""
    palm: NDArray[np.float64]
    """Direction of the palm, (3,)."""
    closing: NDArray[np.float64]
    """Closing direction, (3,). The hand turned by half a turn about the palm counts as equal."""

    @classmethod
    def of(cls, plan: GraspPlan) -> FailedGrasp:
        """Return the record of a plan."""
        width = plan.geometry.width if plan.geometry else plan.opening
        return cls(plan.name, width, plan.palm, plan.closing)

    def equals(self, plan: GraspPlan, *, moved: bool) -> bool:
        """Return whether a plan repeats this grasp.

        An object that moved may have turned, so its directions do not count. On an object that did
        not move, a grasp in another direction is another grasp.
        """
        other = FailedGrasp.of(plan)
        if other.name != self.name:
            return False
        if abs(other.width - self.width) > max(SAME_WIDTH_SHARE * self.width, SAME_WIDTH):
            return False
        same_palm = float(other.palm @ self.palm) > SAME_COSINE
        return moved or (same_palm and abs(float(other.closing @ self.closing)) > SAME_COSINE)


@dataclass(frozen=True, eq=False)
class FailedObject:
    """An object on which picks failed."""

    item: SceneObject
    """The object before the last failure."""
    others: tuple[NDArray[np.float64], ...]
    """Places of the other objects at that time, each (3,), m."""
    grasps: tuple[FailedGrasp, ...]
    """Its failed grasps."""
    slipped: bool
    """Whether it slipped out of the lifted hand."""

    def has_moved(self, item: SceneObject) -> bool:
        """Return whether the object, found again as ``item``, is no longer at its place."""
        return _distance(self.item, item) >= SAME_OBJECT_DISTANCE

    def repeats(self, plan: GraspPlan, item: SceneObject) -> bool:
        """Return whether a plan for the object, found again as ``item``, failed before."""
        moved = self.has_moved(item)
        return any(grasp.equals(plan, moved=moved) for grasp in self.grasps)


@dataclass
class FailedGrasps:
    """Memory of the failed grasps of each object."""

    objects: list[FailedObject] = field(default_factory=list)
    """Objects with failed grasps."""

    def recognise(self, scene: Scene) -> dict[int, FailedObject]:
        """Return label → failed object of the objects of a scene that failed before.

        An object is recognised at its place. Elsewhere it must have the same size, lie within
        `MAX_MOTION`, and not be one of the other objects of that time. Several segments inside
        the former solid are parts of one object: the same image may be segmented otherwise.
        """
        found: dict[int, FailedObject] = {}
        lost: list[FailedObject] = []
        for entry in self.objects:
            near = _nearest(entry, scene, found, SAME_OBJECT_DISTANCE)
            if near is None:
                lost.append(entry)
            else:
                found[near.label] = entry
        for entry in lost:
            near = _nearest(entry, scene, found, MAX_MOTION)
            if near is not None:
                found[near.label] = entry
        for item in scene.objects:
            inside = [entry for entry in self.objects if _is_inside(item, entry)]
            if inside:
                found.setdefault(item.label, inside[-1])
        return found

    def add(
        self, scene: Scene, item: SceneObject, plan: GraspPlan, *, slipped: bool = False
    ) -> None:
        """Add a failed grasp of an object of a scene."""
        known = self.recognise(scene).get(item.label)
        others = tuple(_centre(other) for other in scene.objects if other.label != item.label)
        grasps = (FailedGrasp.of(plan),)
        if known is not None:
            self.objects.remove(known)
            grasps, slipped = (*known.grasps, *grasps), slipped or known.slipped
        self.objects.append(FailedObject(item, others, grasps, slipped))


def _nearest(
    entry: FailedObject, scene: Scene, taken: dict[int, FailedObject], reach: float
) -> SceneObject | None:
    """Return the nearest object that may be that of an entry; None without one."""
    candidates = [
        item
        for item in scene.objects
        if item.label not in taken and _distance(item, entry.item) < reach
    ]
    if reach > SAME_OBJECT_DISTANCE:
        candidates = [
            item
            for item in candidates
            if have_same_size(item, entry.item) and not _was_there(item, entry)
        ]
    return min(candidates, key=lambda item: _distance(item, entry.item), default=None)


def _is_inside(item: SceneObject, entry: FailedObject) -> bool:
    """Return whether the centre of an object lies in the solid of the failed one."""
    solid = entry.item.fit.superquadric
    return solid is not None and bool(solid.contains(_centre(item)))


def _was_there(item: SceneObject, entry: FailedObject) -> bool:
    """Return whether an object stood at its place beside the failed one already."""
    place = _centre(item)
    return any(
        float(np.linalg.norm(other - place)) < SAME_OBJECT_DISTANCE for other in entry.others
    )


def _distance(one: SceneObject, other: SceneObject) -> float:
    return float(np.linalg.norm(_centre(one) - _centre(other)))


def _centre(item: SceneObject) -> NDArray[np.float64]:
    return item.points.mean(axis=0)
