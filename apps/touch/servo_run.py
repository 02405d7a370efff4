"""Run the servo on an arm and record it: land on an object, then control the contact."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, Protocol, TypeVar

import numpy as np
from numpy.typing import NDArray

from eyehand.errors import DeviceError
from eyehand.tactile import TouchPhases

from .arm_rig import CYCLE, ArmRig


@dataclass(frozen=True)
class ServoRun:
    """The record of M cycles from the landing on."""

    time: NDArray[np.float64]
    """(M,), s since the landing."""
    pressure: NDArray[np.float64]
    """(M,), the mean pressure over the soft-rimmed region, Pa."""
    eq12: NDArray[np.float64]
    """(M,), the mean pressure as eq. (12) prints it: over the region with a hard rim, Pa."""
    averaged: NDArray[np.float64]
    """(M,), the same after the servo's filter, Pa."""
    centre: NDArray[np.float64]
    """(M, 2), centre of pressure, m, in the pad's frame; with a lever of shear, the estimated
    place."""
    true_centre: NDArray[np.float64]
    """(M, 2), true centre of pressure, m; NaN without contact."""
    area: NDArray[np.float64]
    """(M,), area of the contact region, m²; 0 without contact."""
    force: NDArray[np.float64]
    """(M,), true normal force, N."""
    normal: NDArray[np.float64]
    """(M, 3), z-axis of the pad in the world frame."""
    position: NDArray[np.float64]
    """(M, 3), origin of the pad in the world frame, m."""
    serving: NDArray[np.bool_]
    """(M,), whether the servo is active. Before, a light touch may be lost in the noise."""
    outcome: str | None
    """Why the phase machine ended the run; None if it did not."""


class RecordedTrial(Protocol):
    """A trial with the record of its run."""

    @property
    def run(self) -> ServoRun:
        """The record. It has an outcome if the servo ended the trial early."""
        ...


AnyTrial = TypeVar("AnyTrial", bound=RecordedTrial)


def lasting(trials: Sequence[AnyTrial]) -> tuple[list[AnyTrial], dict[str, Any]]:
    """Return the trials that lasted, and their number, that of the others, and their outcomes.

    Raises
    ------
    DeviceError
        If none lasted.
    """
    lasted = [trial for trial in trials if not trial.run.outcome]
    ended = [trial.run.outcome for trial in trials if trial.run.outcome]
    names = " ".join(sorted(set(ended)))
    if not lasted:
        raise DeviceError(f"all {len(trials)} trials ended early: {names}")
    return lasted, {"trials": len(lasted), "ended_early": len(ended), "outcomes": names}


def run_servo(
    rig: ArmRig,
    phases: TouchPhases,
    seconds: float,
    external: Callable[[float], NDArray[np.float64]] | None = None,
    move: Callable[[float], None] | None = None,
) -> ServoRun:
    """Approach, land, and control the contact until a time after the landing.

    Parameters
    ----------
    rig
        A rig with one arm above an object.
    phases
        Phase machine with the servo and its goal.
    seconds
        Duration of the record, s.
    external
        Returns the external twist (6,) for a time since the landing, s. None: no external twist.
    move
        Called with the time since the landing, s, in every simulation step, to move mocap bodies.

    Returns
    -------
    ServoRun
        Shorter than `seconds` if the phase machine ended the run; empty if nothing was touched.
    """
    rows: list[tuple] = []
    hand = rig.hand
    landing: float | None = None

    def move_bodies(time: float) -> None:
        if move is not None and landing is not None:
            move(time - landing)

    while landing is None or rig.time - landing < seconds:
        since = 0.0 if landing is None else rig.time - landing
        outer = None if external is None or landing is None else external(since)
        phases.servo.side_force = hand.side_force
        step = phases.step(hand.features, CYCLE, external=outer, measured=hand.twist)
        if step.outcome is not None:
            break
        if landing is None and hand.features:
            landing = rig.time
        sample = rig.step(step.twist, move=move_bodies if move else None)[-1][0]
        if landing is None:
            continue
        pose, features, place = hand.pose, hand.features, phases.servo.place
        rows.append(
            (
                rig.time - landing,
                features.pressure,
                features.force / max(features.tactels, 1) / hand.tactel_area,
                phases.servo.filtered[0],
                features.centre[:2].copy() if place is None else place,
                sample.centre[:2],
                features.area,
                sample.force,
                pose.rotation.as_matrix()[:, 2],
                pose.translation,
                step.phase == "task",
            )
        )
    columns = [np.array(column) for column in zip(*rows, strict=True)] or [np.zeros(0)] * 11
    return ServoRun(*columns, outcome=phases.outcome)
