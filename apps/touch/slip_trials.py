"""Simulated trials with and without slip: objects, events, and what the pad reads in them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from eyehand.data_synth.pad import IMAGE_RATE, HeldObject, HeldSimulation, SensorModel
from eyehand.tactile import SlipState

Drive = Callable[[float], tuple[float, NDArray[np.float64], float]]


SECONDS, SETTLED = 0.55, 0.2
"""Length of a trial, and the time from which alarms count, s. The weight acts within 0.1 s."""
STRIDE = 4
"""Images per judgement: 475 judgements a second."""
WINDOW = 32
"""Images in the window of the chapter's Fourier features: 17 ms."""
GRAVITY = 9.81
STATIC_RATIO = 1.2
"""Ratio of static to sliding friction of the simulated foam."""
_LOADING = 0.1
_LEAD = 0.04
"""Time before `SETTLED` from which the pad is read, s."""
_MAX_SETTLING_SLIDE = 5e-5
"""Slide before the event up to which the object counts as held, m."""
_PRESSURES = (400.0, 8e3)
"""Range of the mean pressure on the face, Pa."""

PADS, UNSEEN_PADS = range(6), range(6, 12)
"""Numbers of the pads that detectors are trained on, and of those that they are tested on."""
TRAIN_SHAPES = ("block", "can", "ball")
TEST_SHAPES = ("bar", "bottle", "tool")
"""Kinds of objects: those trained on, and those tested on."""
SLIP_EVENTS = ("load", "release", "acceleration", "pull", "twist")
"""Events that cause slip if they are strong enough."""
CALM_EVENTS = ("knock", "regrip", "unload")
"""Events that cause no slip, but for a few strong knocks."""
EVENTS = SLIP_EVENTS + CALM_EVENTS


@dataclass(frozen=True)
class SlipTrial:
    """What the pad read in one trial, at T judgements."""

    event: str
    """One of `EVENTS`."""
    time: NDArray[np.float64]
    """(T,), s."""
    features: NDArray[np.float32]
    """(T, FEATURES), see :mod:`eyehand.tactile.slip_features`."""
    spectra: NDArray[np.float32]
    """(T, WINDOW / 2): mean amplitude of each frequency, as a share of the mean pressure."""
    slide: NDArray[np.float64]
    """True slide since `SETTLED`, (T,), m."""


@dataclass(frozen=True)
class HeldGrasp:
    """One object in the grip."""

    held: HeldObject
    grip: float
    """Grip force, N."""
    direction: NDArray[np.float64]
    """Direction of gravity on the pad, (2,)."""
    angle: float
    """Angle of the face, rad."""

    @property
    def limit(self) -> float:
        """Largest tangential load, N, without torque."""
        return 2 * STATIC_RATIO * self.held.friction * self.grip


def draw_grasp(shape: str, rng: np.random.Generator) -> HeldGrasp:
    """Draw an object of a kind and a grip of 1.35 to 2.2 times the minimum."""
    while True:
        held = _draw_object(shape, rng)
        grip = held.mass * GRAVITY / (2 * STATIC_RATIO * held.friction) * rng.uniform(1.35, 2.2)
        if _PRESSURES[0] < grip / (4 * held.half_x * held.half_y) < _PRESSURES[1]:
            break
    turn = rng.uniform(-np.pi, np.pi)
    return HeldGrasp(
        held, grip, np.array([np.cos(turn), np.sin(turn)]), float(rng.uniform(-np.pi, np.pi))
    )


def run_slip_trial(
    shape: str, event: str, seed: int, sensor: SensorModel, max_pressure: float, pad: int = 0
) -> SlipTrial:
    """Hold an object through one event.

    Parameters
    ----------
    shape
        One of `TRAIN_SHAPES` and `TEST_SHAPES`.
    event
        One of `EVENTS`.
    seed
        Source of the object, the event and the noise. Objects that do not stay in the grip until
        the event are drawn again.
    sensor
        Sensor model.
    max_pressure, pad
        Range of the pad, Pa, and its number.
    """
    rng = np.random.default_rng((seed, EVENTS.index(event)))
    while True:
        grasp = draw_grasp(shape, rng)
        drive = EVENT_DRIVES[event](grasp, rng)
        simulation = HeldSimulation(
            grasp.held,
            grasp.grip,
            max_pressure=max_pressure,
            sensor=sensor,
            angle=grasp.angle,
            pad=pad,
            seed=seed,
        )
        trial = _run(grasp, event, drive, simulation)
        if trial is not None:
            return trial


def _run(
    grasp: HeldGrasp, event: str, drive: Drive, simulation: HeldSimulation
) -> SlipTrial | None:
    """Run one trial; None if the object slides before the event."""
    rows, columns = simulation.array.grid or (0, 0)
    state = SlipState(
        rows,
        columns,
        simulation.pitch,
        simulation.noise_floor,
        1 / IMAGE_RATE,
        simulation.shear_stiffness,
    )
    weight = grasp.held.mass * GRAVITY * grasp.direction
    window = np.zeros((WINDOW, rows * columns))
    settled, count = 0.0, int(SECONDS * IMAGE_RATE)
    times, features, spectra, slides = [], [], [], []
    for k in range(count):
        time = (k + 1) / IMAGE_RATE
        grip, force, torque = drive(time)
        simulation.advance(grip, tuple(weight * min(time / _LOADING, 1.0) + force), torque)
        if time < SETTLED - _LEAD:
            continue
        pressures, shear = simulation.read()
        values = state.update(pressures, shear)
        window[k % WINDOW] = pressures
        if time < SETTLED:
            settled = simulation.slide
            if settled > _MAX_SETTLING_SLIDE:
                return None
        elif k % STRIDE == 0:
            times.append(time)
            features.append(values.astype(np.float32))
            spectra.append(fourier_features(np.roll(window, -(k + 1), axis=0), state.threshold))
            slides.append(simulation.slide - settled)
    return SlipTrial(
        event, np.array(times), np.array(features), np.array(spectra), np.array(slides)
    )


def fourier_features(window: NDArray[np.float64], threshold: float) -> NDArray[np.float32]:
    """Return the chapter's features of a window (WINDOW, N): amplitudes over the frequency.

    They are means over the tactels that touch, as a share of their mean pressure.
    """
    mean = window.mean(axis=0)
    touching = mean > threshold
    if not touching.any():
        return np.zeros(WINDOW // 2, np.float32)
    amplitudes = np.abs(np.fft.rfft(window[:, touching], axis=0)[1:])
    return (amplitudes.mean(axis=1) / mean[touching].mean()).astype(np.float32)


def _draw_object(shape: str, rng: np.random.Generator) -> HeldObject:
    half_x, half_y = rng.uniform(0.008, 0.018, 2)
    curve_x = curve_y = 0.0
    roughness = rng.uniform(2e-6, 2e-5)
    if shape in ("can", "ball"):
        curve_x = 1 / rng.uniform(0.02, 0.06)
        curve_y = curve_x if shape == "ball" else 0.0
    elif shape == "bar":
        half_x, half_y = rng.uniform(0.004, 0.007), rng.uniform(0.015, 0.025)
    elif shape == "bottle":
        curve_x, curve_y = 1 / rng.uniform(0.03, 0.05), 1 / rng.uniform(0.1, 0.3)
    elif shape == "tool":
        half_x, roughness = rng.uniform(0.006, 0.010), rng.uniform(2e-5, 4e-5)
    return HeldObject(
        mass=float(np.exp(rng.uniform(np.log(0.03), np.log(0.6)))),
        friction=rng.uniform(0.25, 1.0),
        half_x=half_x,
        half_y=half_y,
        curve_x=curve_x,
        curve_y=curve_y,
        centre_x=rng.uniform(-0.003, 0.003),
        centre_y=rng.uniform(-0.003, 0.003),
        gyration=rng.uniform(0.02, 0.05),
        roughness=roughness,
        friction_spread=rng.uniform(0.02, 0.1),
    )


def _ramp(time: float, start: float, rise: float) -> float:
    return min(max((time - start) / rise, 0.0), 1.0)


def _start(rng: np.random.Generator) -> float:
    return float(rng.uniform(SETTLED + 0.03, SETTLED + 0.1))


def _load(grasp: HeldGrasp, rng: np.random.Generator) -> Drive:
    start, rise = _start(rng), rng.uniform(0.01, 0.06)
    added = rng.uniform(0.5, 1.2) * grasp.limit - grasp.held.mass * GRAVITY
    force = added * grasp.direction
    return lambda time: (grasp.grip, force * _ramp(time, start, rise), 0.0)


def _pull(grasp: HeldGrasp, rng: np.random.Generator) -> Drive:
    start, turn = _start(rng), rng.uniform(-np.pi, np.pi)
    force = rng.uniform(0.2, 1.2) * grasp.limit * np.array([np.cos(turn), np.sin(turn)])
    return lambda time: (grasp.grip, force * _ramp(time, start, 0.25), 0.0)


def _release(grasp: HeldGrasp, rng: np.random.Generator) -> Drive:
    start, fall = _start(rng), rng.uniform(0.03, 0.2)
    least = min(grasp.held.mass * GRAVITY / grasp.limit * rng.uniform(0.8, 1.7), 1.0)
    return lambda time: (
        grasp.grip * (1 + (least - 1) * _ramp(time, start, fall)),
        np.zeros(2),
        0.0,
    )


def _acceleration(grasp: HeldGrasp, rng: np.random.Generator) -> Drive:
    start, length, turn = _start(rng), rng.uniform(0.06, 0.2), rng.uniform(-np.pi, np.pi)
    force = rng.uniform(0.2, 1.1) * grasp.limit * np.array([np.cos(turn), np.sin(turn)])

    def drive(time: float) -> tuple[float, NDArray[np.float64], float]:
        return grasp.grip, force * np.sin(np.pi * _ramp(time, start, length)), 0.0

    return drive


def _twist(grasp: HeldGrasp, rng: np.random.Generator) -> Drive:
    start, rise = _start(rng), rng.uniform(0.02, 0.1)
    # A face of this extent turns at about the limit times half its mean radius.
    arm = 0.4 * (grasp.held.half_x + grasp.held.half_y)
    torque = rng.choice([-1.0, 1.0]) * rng.uniform(0.1, 0.9) * grasp.limit * arm
    return lambda time: (grasp.grip, np.zeros(2), torque * _ramp(time, start, rise))


def _knock(grasp: HeldGrasp, rng: np.random.Generator) -> Drive:
    """Return a ringing of the hand: its inertia loads the object, and the grip force shakes."""
    start, turn = _start(rng), rng.uniform(-np.pi, np.pi)
    frequency, decay = rng.uniform(40, 150), rng.uniform(0.01, 0.04)
    force = rng.uniform(0.1, 0.7) * grasp.limit * np.array([np.cos(turn), np.sin(turn)])
    shaken, phase = rng.uniform(0.02, 0.15), rng.uniform(-np.pi, np.pi)

    def drive(time: float) -> tuple[float, NDArray[np.float64], float]:
        since = max(time - start, 0.0)
        size = np.exp(-since / decay) if since > 0 else 0.0
        swing = 2 * np.pi * frequency * since
        grip = grasp.grip * (1 + shaken * size * np.sin(swing + phase))
        return grip, force * size * np.sin(swing), 0.0

    return drive


def _regrip(grasp: HeldGrasp, rng: np.random.Generator) -> Drive:
    start, rise = _start(rng), rng.uniform(0.02, 0.15)
    factor = rng.uniform(1.1, 2.0)
    return lambda time: (
        grasp.grip * (1 + (factor - 1) * _ramp(time, start, rise)),
        np.zeros(2),
        0.0,
    )


def _unload(grasp: HeldGrasp, rng: np.random.Generator) -> Drive:
    start, rise = _start(rng), rng.uniform(0.02, 0.15)
    force = -rng.uniform(0.3, 1.0) * grasp.held.mass * GRAVITY * grasp.direction
    return lambda time: (grasp.grip, force * _ramp(time, start, rise), 0.0)


EVENT_DRIVES: dict[str, Callable[[HeldGrasp, np.random.Generator], Drive]] = dict(
    zip(
        EVENTS,
        (_load, _release, _acceleration, _pull, _twist, _knock, _regrip, _unload),
        strict=True,
    )
)
"""Event → function that draws the grip force, load and torque over time."""
