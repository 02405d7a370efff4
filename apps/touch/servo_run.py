"""One run of the servo on an arm, recorded: land on an object, then do the task."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from .arm_rig import CYCLE

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    from eyehand.tactile import TouchPhases

    from .arm_rig import ArmRig


@dataclass(frozen=True)
class ServoRun:
    """M cycles from the landing on."""

    time: NDArray[np.float64]
    """(M,), s since the landing."""
    pressure: NDArray[np.float64]
    """(M,), the feature of eq. 12, Pa."""
    averaged: NDArray[np.float64]
    """(M,), the same as the servo averages it, Pa."""
    centre: NDArray[np.float64]
    """(M, 2), centre of pressure, m, in the pad's frame."""
    true_centre: NDArray[np.float64]
    """(M, 2), as it truly is, m; NaN without contact."""
    area: NDArray[np.float64]
    """(M,), of the contact region, m²; 0 without contact."""
    force: NDArray[np.float64]
    """(M,), the true normal force, N."""
    normal: NDArray[np.float64]
    """(M, 3), the pad's z-axis in the world."""
    place: NDArray[np.float64]
    """(M, 3), the pad's origin in the world, m."""
    serving: NDArray[np.bool_]
    """(M,), whether the servo acts; before, the touch may flicker, as it is in the noise."""
    outcome: str | None
    """How the phase machine ended it; None if it did not."""


def run_servo(
    rig: ArmRig,
    phases: TouchPhases,
    seconds: float,
    external: Callable[[float], NDArray[np.float64]] | None = None,
    move: Callable[[float], None] | None = None,
) -> ServoRun:
    """Approach, land, and serve until a time after the landing.

    Parameters
    ----------
    rig
        With one arm, over an object.
    phases
        With servo, goal and switches.
    seconds
        Length of the record, s.
    external
        Gives the outer motion (6,) at a time since the landing, s; none if left out.
    move
        Called with the time since the landing, s, in every step, to place mocap bodies.

    Returns
    -------
    ServoRun
        Shorter than asked if the phase machine ended it, empty if nothing was touched.
    """
    rows: list[tuple] = []
    hand = rig.hand
    landing: float | None = None

    def place(time: float) -> None:
        if move is not None and landing is not None:
            move(time - landing)

    while landing is None or rig.time - landing < seconds:
        since = 0.0 if landing is None else rig.time - landing
        outer = None if external is None or landing is None else external(since)
        step = phases.step(hand.features, CYCLE, external=outer, measured=hand.twist)
        if step.outcome is not None:
            break
        if landing is None and hand.features:
            landing = rig.time
        moment = rig.step(step.twist, move=place if move else None)[-1][0]
        if landing is None:
            continue
        pose, features = hand.pose, hand.features
        rows.append(
            (
                rig.time - landing,
                features.pressure,
                phases.servo.filtered[0],
                features.centre[:2].copy(),
                moment.centre[:2],
                features.area,
                moment.force,
                pose.rotation.as_matrix()[:, 2],
                pose.translation,
                step.phase == "task",
            )
        )
    columns = [np.array(column) for column in zip(*rows, strict=True)] or [np.zeros(0)] * 10
    return ServoRun(*columns, outcome=phases.outcome)
