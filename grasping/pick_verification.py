"""Verify the outcome of a pick with the next perceived scene."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from eyehand.perception import Scene, SceneObject, Superquadric, SuperquadricFit

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


def verify_pick(report: PickReport, grasp: SelectedGrasp, scene: Scene, tray: Tray) -> PickReport:
    """Correct the outcome of a pick by the scene perceived after it.

    Touch can be wrong: fingers that press on each other feel the same force as a held object.
    Therefore a placed object must have disappeared from its place. The distance of fingertips at
    the release shows that they held something. Only after a power grasp, whose fingertips may meet,
    an object of the same size elsewhere is taken for the placed one.

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
    found = _find_again(grasp, scene) if report else None
    if found is None:
        return report
    if _distance(found, place) < SAME_OBJECT_DISTANCE:
        reason = "the hand held nothing: the object is still at its place"
        return replace(report, outcome="empty_close", reason=reason)
    if tray.distance(_centre(found)) < BESIDE_TRAY_DISTANCE:
        return replace(report, outcome="place_failed", reason="the object lies beside the tray")
    if grasp.plan.prototype != "power":
        return report
    return replace(report, outcome="lost", reason="the object lies elsewhere on the table")


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
