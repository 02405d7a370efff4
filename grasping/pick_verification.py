"""Verify the outcome of a pick with the next perceived scene."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from eyehand.perception import Scene, SceneObject, Superquadric, SuperquadricFit

    from .depth_change import DepthChange
    from .pick_state import SelectedGrasp
    from .report import PickReport
    from .tray import Tray

SAME_OBJECT_DISTANCE = 0.03
"""Distance below which two perceived centres belong to the same object, m. Objects do not move by
themselves, and the centres of repeated fits differ by less."""
SIZE_TOLERANCE_SHARE, SIZE_TOLERANCE = 0.2, 0.005
"""Maximum difference of the semi-axes of one object in two scenes, as a share and in m; the larger
of the two counts."""
BESIDE_TRAY_DISTANCE = 0.1
"""Distance from the tray up to which an object counts as fallen beside it, m."""

MIN_REMAINING, MAX_REMAINING = 0.5, 0.2
"""Minimum share of the surface of an object that is still at its place, and maximum share of one
that left it. The share is above 0.8 for 98 % of the objects at rest. It is at most 0.37 for picked
ones."""
UNTOUCHED = 0.8
"""Minimum share of the planned object where nothing else left its place. A segment of two objects
keeps a part of its surface when one of them is picked."""
MIN_APPEARED, MIN_SHIFTED = 0.5, 0.2
"""Minimum share of an object's surface at formerly free places by which it is new, and by which one
of the picked object's size is that object. It may overlap its former place. The share is about 0.1
at most at rest."""


def verify_pick(
    report: PickReport,
    grasp: SelectedGrasp,
    scene: Scene,
    tray: Tray,
    change: DepthChange | None = None,
) -> PickReport:
    """Correct the outcome of a pick by the scene perceived after it.

    Touch can be wrong: fingers that press on each other feel the same force as a held object.
    Therefore a placed object must have disappeared from its place. The distance of fingertips at
    the release shows that they held something. Only after a power grasp, whose fingertips may meet,
    an object of the same size elsewhere is taken for the placed one.

    The depth images show more: which surfaces are still there, and which are new. They detect
    another object in the hand, and an object that fell, also if the number of objects changed.

    Parameters
    ----------
    report
        Outcome of the pick according to touch.
    grasp
        The executed grasp, with the scene before it.
    scene
        The scene after the pick, without the objects in the tray.
    tray
        The tray that the object was put into.
    change
        The depth images before and after the pick. None without images.

    Returns
    -------
    PickReport
        The same report, or one with another outcome and reason.
    """
    place = _centre(grasp.target)
    if report.outcome in ("empty_close", "no_contact"):
        if not any(_distance(item, place) < SAME_OBJECT_DISTANCE for item in scene.objects):
            reason = f"{report.reason}; the object is no longer at its place"
            return replace(report, outcome="moved_away", reason=reason)
        return report
    if report and change is not None:
        report = _verify_surfaces(report, grasp, scene, tray, change)
    found = _find_again(grasp, scene) if report else None
    if found is None:
        return report
    if _distance(found, place) < SAME_OBJECT_DISTANCE:
        return _still_at_place(report)
    if tray.distance(_centre(found)) < BESIDE_TRAY_DISTANCE:
        return replace(report, outcome="place_failed", reason="the object lies beside the tray")
    if grasp.plan.prototype != "power":
        return report
    return replace(report, outcome="lost", reason="the object lies elsewhere on the table")


def _verify_surfaces(
    report: PickReport, grasp: SelectedGrasp, scene: Scene, tray: Tray, change: DepthChange
) -> PickReport:
    """Correct the outcome of a placed object by the surfaces that left and the new ones."""
    stay = change.remaining(grasp.target.points)
    if stay is None:
        return report
    neighbours = [item for item in grasp.scene.objects if item is not grasp.target]
    others = [change.remaining(item.points) for item in neighbours]
    came = [(change.appeared(item.points) or 0.0, item) for item in scene.objects]
    new = [item for share, item in came if share >= MIN_APPEARED]
    if stay >= MIN_REMAINING:
        left = sum(share is not None and share <= MAX_REMAINING for share in others)
        if left > len(new):
            reason = "the object is still at its place, and another one is gone"
            return replace(report, outcome="wrong_object", reason=reason)
        return _still_at_place(report) if stay >= UNTOUCHED else report
    if any(share is None or share < MIN_REMAINING for share in others):
        # A neighbour moved, or is hidden: a new surface may be that of the neighbour.
        return report
    if any(tray.distance(_centre(item)) < BESIDE_TRAY_DISTANCE for item in new):
        return replace(report, outcome="place_failed", reason="the object lies beside the tray")
    # A new surface of another size may be an object that the picked one had hidden.
    if any(share >= MIN_SHIFTED and have_same_size(item, grasp.target) for share, item in came):
        return replace(report, outcome="lost", reason="the object lies elsewhere on the table")
    return report


def _still_at_place(report: PickReport) -> PickReport:
    reason = "the hand held nothing: the object is still at its place"
    return replace(report, outcome="empty_close", reason=reason)


def _find_again(grasp: SelectedGrasp, scene: Scene) -> SceneObject | None:
    """Find the picked object in the scene after the pick.

    It must have the same size and must not be one of the other objects before the pick. If the
    scene has fewer objects than before, a new object was hidden before, so None is returned.
    """
    if len(scene.objects) < len(grasp.scene.objects):
        return None
    others = [_centre(item) for item in grasp.scene.objects if item is not grasp.target]
    new = [
        item
        for item in scene.objects
        if have_same_size(item, grasp.target)
        and all(_distance(item, other) >= SAME_OBJECT_DISTANCE for other in others)
    ]
    return min(new, key=lambda item: _distance(item, _centre(grasp.target)), default=None)


def have_same_size(one: SceneObject, other: SceneObject) -> bool:
    """Return whether the solids of two objects have the same size."""
    first, second = one.fit.superquadric, other.fit.superquadric
    if first is None or second is None:
        return False
    a, b = _half_sizes(first, one.fit), _half_sizes(second, other.fit)
    return bool((np.abs(a - b) <= np.maximum(SIZE_TOLERANCE_SHARE * b, SIZE_TOLERANCE)).all())


def _half_sizes(solid: Superquadric, fit: SuperquadricFit) -> NDArray[np.float64]:
    """Return half the widths of all parts along the axes of the largest, sorted, (3,), m."""
    if len(fit.parts) < 2:
        return np.sort(solid.semi_axes)
    axes = solid.rotation.T
    reach = [part.support(np.vstack([axes, -axes])) for part in fit.parts]
    return np.sort(0.5 * np.max(reach, axis=0).reshape(2, 3).sum(axis=0))


def _centre(item: SceneObject) -> NDArray[np.float64]:
    return item.points.mean(axis=0)


def _distance(item: SceneObject, place: NDArray[np.float64]) -> float:
    return float(np.linalg.norm(_centre(item) - place))
