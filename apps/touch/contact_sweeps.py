"""Stress sweeps over difficult contacts: lost, round, misaligned, on the border, moving, light."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from eyehand.data_synth.pad import Part, SensorModel, TouchObject, pen, tilted_face, toy_box

from ..bench import Trial, as_sweep
from .stress_trial import CALM_CONTACT, ContactFigures, hold_contact, servo_phases
from .stress_world import CarriedPad, Electronics

TILT = np.radians(6.0)
"""Initial tilt of the pad before it rolls flat, rad, as in Haschke's chapter."""
FACE_SIDE = 0.06
"""Side length of the face that the pad rolls onto, m."""
FLAT = np.radians(1.0)
"""Maximum tilt of a pad that counts as flat, rad."""
ROUND_TURN = np.radians(2.0)
"""Maximum rotation over a round contact, rad. Noise alone may cause this much."""
IN_LINE = np.radians(3.0)
"""Maximum direction error of a pad that counts as aligned with a rod, rad."""
NOISES = (2.0, 5.0, 10.0, 20.0, 40.0, 80.0, 160.0)
"""Standard deviations of a reading, counts; full scale is 4095. The default electronics have 2."""
DROP_SECONDS, DROP_TIMES = 0.2, (0.4, 2.4)
"""Duration and start times of the object's drops, s. The pad first rolls and then lies flat."""
BLOB_DISTANCE = 0.04
"""Distance between two blobs, m."""
SWAP_HERTZ = 4.0
"""Rate at which the two blobs exchange their heights, 1/s."""
MOTION_START = 1.0
"""Start time of the object's motion, s. The pad has settled on the object by then."""
ROD_RADIUS, ROD_HALF, BALL_RADIUS = 0.003, 0.05, 0.02
"""Radius and half length of a rod, and radius of a ball, m."""
PLATE_HALF = (0.02, 0.02, 0.005)
"""Half side lengths of a light flat object, m."""


@as_sweep(
    "lost-rolling", "distance of two drops for 0.2 s, the first while the pad rolls", "mm",
    (0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 20.0), holds_to=0.2,
    right="contact found again, pressure reached, flat within 1°",
)  # fmt: skip
def _lost(drop: float, seed: int, sensor: SensorModel) -> Trial:
    def lifts(time: float) -> tuple[float]:
        dropped = any(begin < time < begin + DROP_SECONDS for begin in DROP_TIMES)
        return (-1e-3 * drop if dropped else 0.0,)

    # The pad is tilted, so its lower rim touches first.
    height = 0.5 * FACE_SIDE * np.sin(TILT) + 0.001
    pad = CarriedPad(
        (tilted_face(0.0, side=FACE_SIDE),),
        Electronics(seed, sensor),
        place=(0.0, 0.0, height),
        lean=(TILT * np.cos(seed), TILT * np.sin(seed), 0.0),
    )
    return hold_contact(
        pad,
        servo_phases("roll", sensor),
        6.0,
        lifts,
        lambda run: _excess_note("tilted by", run.tilt, FLAT),
        # The object itself jumps up against the pad, so the peak says nothing about the servo.
        max_peak=np.inf,
    )


@as_sweep(
    "round", "noise, with yaw control over a ball", "counts", NOISES, holds_to=10.0,
    right="rotated by less than 2°",
)  # fmt: skip
def _round(noise: float, seed: int, sensor: SensorModel) -> Trial:
    pad = CarriedPad((_ball(0.0, 0.0),), Electronics(seed, replace(sensor, noise=noise)))
    return hold_contact(
        pad,
        servo_phases("cable", sensor),
        find_error=lambda run: _excess_note("turned by", run.turned, ROUND_TURN),
    )


@as_sweep(
    "right-angle", "noise, with a rod exactly 90° misaligned", "counts", NOISES, holds_to=10.0,
    right="aligned within 3°",
)  # fmt: skip
def _right_angle(noise: float, seed: int, sensor: SensorModel) -> Trial:
    # Quaternion of 90° about y: the rod lies along x.
    half = np.sqrt(0.5)
    part = Part("capsule", (ROD_RADIUS, ROD_HALF), (0.0, 0.0, -ROD_RADIUS), (half, 0.0, half, 0.0))
    pad = CarriedPad(
        (TouchObject("rod", (part,)),), Electronics(seed, replace(sensor, noise=noise))
    )

    def misaligned(run: ContactFigures) -> str:
        return _excess_note("out of line by", abs(abs(run.heading) - 0.5 * np.pi), IN_LINE)

    return hold_contact(pad, servo_phases("edge", sensor), 5.0, find_error=misaligned)


@as_sweep(
    "border", "distance of the contact from the pad's centre (border at 40)", "mm",
    (0.0, 20.0, 30.0, 33.0, 36.0, 38.0, 40.0, 42.0, 45.0), holds_to=30.0, right=CALM_CONTACT,
)  # fmt: skip
def _border(distance_mm: float, seed: int, sensor: SensorModel) -> Trial:
    angle = 0.25 * np.pi * (seed % 8)
    # The distance is the larger of |x| and |y|, because it decides how near the border is.
    place = 1e-3 * distance_mm * np.array([np.cos(angle), np.sin(angle)])
    place *= distance_mm * 1e-3 / max(np.abs(place).max(), 1e-9)
    return hold_contact(
        CarriedPad((_ball(*place),), Electronics(seed, sensor)), servo_phases("press", sensor), 12.0
    )


@as_sweep(
    "blobs", "height difference of two blobs that alternate 4 times per second", "mm",
    (0.0, 0.02, 0.05, 0.1, 0.2, 0.5, 1.0), holds_to=None, right=CALM_CONTACT,
)  # fmt: skip
def _blobs(lift: float, seed: int, sensor: SensorModel) -> Trial:
    def lifts(time: float) -> tuple[float, float]:
        up = 0.5e-3 * lift * np.sin(np.pi * SWAP_HERTZ * time + seed)
        return up, -up

    single = pen().parts[0]
    blobs = tuple(
        TouchObject(name, (replace(single, place=(x, 0.0, single.place[2])),))
        for name, x in (("left", -0.5 * BLOB_DISTANCE), ("right", 0.5 * BLOB_DISTANCE))
    )
    return hold_contact(
        CarriedPad(blobs, Electronics(seed, sensor)), servo_phases("press", sensor), lifts=lifts
    )


# The pad retreats at no more than 50 mm/s, so faster objects are not tested.
@as_sweep(
    "coming", "speed of a box that moves towards the pad without stopping", "mm/s",
    (2.0, 5.0, 8.0, 10.0, 12.0, 15.0, 20.0, 30.0, 40.0), holds_to=8.0, right=CALM_CONTACT,
)  # fmt: skip
def _coming(speed: float, seed: int, sensor: SensorModel) -> Trial:
    def lifts(time: float) -> tuple[float]:
        # The object accelerates for one second, as an arm or a belt does.
        elapsed = max(time - MOTION_START, 0.0)
        return (1e-3 * speed * (0.5 * elapsed * elapsed if elapsed < 1.0 else elapsed - 0.5),)

    return hold_contact(
        CarriedPad((toy_box(),), Electronics(seed, sensor)),
        servo_phases("press", sensor),
        5.0,
        lifts,
    )


@as_sweep(
    "light", "mass of a free flat object on a table", "g",
    (200.0, 100.0, 50.0, 20.0, 10.0, 5.0, 2.0, 1.0), holds_to=5.0, right=CALM_CONTACT,
)  # fmt: skip
def _light(mass: float, seed: int, sensor: SensorModel) -> Trial:
    plate = TouchObject("plate", (Part("box", PLATE_HALF, (0.0, 0.0, -PLATE_HALF[2])),))
    pad = CarriedPad((plate,), Electronics(seed, sensor), mass=1e-3 * mass)
    return hold_contact(pad, servo_phases("track", sensor))


def _ball(x: float, y: float) -> TouchObject:
    return TouchObject("ball", (Part("sphere", (BALL_RADIUS,), (x, y, -BALL_RADIUS)),))


def _excess_note(words: str, angle: float, limit: float) -> str:
    """Return a note if an angle reaches its limit, or an empty string."""
    return "" if angle < limit else f"{words} {np.degrees(angle):.1f}°"


CONTACT_SWEEPS = (_lost, _round, _right_angle, _border, _blobs, _coming, _light)
"""Sweeps over the object under the pad and its motion."""
