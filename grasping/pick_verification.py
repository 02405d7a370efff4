"""What the next look tells of a pick: gone from its place, still there, or beside the tray."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from eyehand.perception import Scene, SceneObject

    from .pick_state import Choice
    from .report import PickReport
    from .tray import Tray

SAME_PLACE = 0.03
"""An object seen so near the place of an earlier one is that one, m: they do not move by
themselves, and centres of fits of one object differ by less."""
ALIKE_SHARE, ALIKE_LENGTH = 0.2, 0.005
"""Semi-axes of one object in two looks differ by less than this share of them or this length, m."""
BESIDE = 0.1
"""What lies so near the tray, m, fell as it was put down."""


def seen_after(report: PickReport, choice: Choice, scene: Scene, tray: Tray) -> PickReport:
    """Revise what a pick tells of itself by what is seen after it.

    Touch may be wrong: fingers that press on each other feel what holds feel. So what counts as
    placed must be gone from the table.

    Parameters
    ----------
    report
        How the pick ended by touch.
    choice
        What was picked, and the scene that it was seen in.
    scene
        What is seen now, less what lies in the tray.
    tray
        Where the object should be.

    Returns
    -------
    PickReport
        The same where nothing speaks against it.
    """
    place = _middle(choice.target)
    if report.outcome in ("empty_close", "no_contact"):
        if not any(_apart(one, place) < SAME_PLACE for one in scene.objects):
            reason = f"{report.reason}; it is no longer where it was seen"
            return replace(report, outcome="moved_away", reason=reason)
        return report
    again = _again(choice, scene) if report else None
    if again is None:
        return report
    if _apart(again, place) < SAME_PLACE:
        reason = "the hand held nothing: it is still where it was seen"
        return replace(report, outcome="empty_close", reason=reason)
    if tray.distance(_middle(again)) < BESIDE:
        return replace(report, outcome="place_failed", reason="it lies beside the tray")
    return replace(report, outcome="lost", reason="it lies on the table, elsewhere than before")


def _again(choice: Choice, scene: Scene) -> SceneObject | None:
    """Find the object picked among those seen after: alike, and not one of the others before.

    Nothing is found while fewer are seen than before: then what is new came to light behind it.
    """
    if len(scene.objects) < len(choice.scene.objects):
        return None
    others = [_middle(one) for one in choice.scene.objects if one is not choice.target]
    new = [
        one
        for one in scene.objects
        if _alike(one, choice.target) and all(_apart(one, at) >= SAME_PLACE for at in others)
    ]
    return min(new, key=lambda one: _apart(one, _middle(choice.target)), default=None)


def _alike(one: SceneObject, other: SceneObject) -> bool:
    first, second = one.fit.superquadric, other.fit.superquadric
    if first is None or second is None:
        return False
    a, b = np.sort(first.semi_axes), np.sort(second.semi_axes)
    return bool((np.abs(a - b) <= np.maximum(ALIKE_SHARE * b, ALIKE_LENGTH)).all())


def _middle(one: SceneObject) -> NDArray[np.float64]:
    return one.points.mean(axis=0)


def _apart(one: SceneObject, place: NDArray[np.float64]) -> float:
    return float(np.linalg.norm(_middle(one) - place))
