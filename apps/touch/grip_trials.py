"""Simulated trials of grip force: an object is grasped, pulled, lifted, loaded and shaken."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from eyehand.data_synth.pad import IMAGE_RATE, HeldObject, HeldSimulation, SensorModel
from eyehand.tactile import (
    FrictionPull,
    GripLaw,
    GripReading,
    LoadGrip,
    SlipDetector,
    SlipGrip,
    SlipScore,
    SlipState,
)

from .slip_trials import GRAVITY, STATIC_RATIO, STRIDE, UNSEEN_PADS

LAWS = (
    "constant",
    "chapter",
    "pull + wrist",
    "pull + lever",
    "pull + shear",
    "all-knowing",
)
"""Grip laws of the table."""
SENSELESS = ("constant", "all-knowing")
"""Laws that read neither pad nor wrist."""
FIRST_GRIP = 12.0
"""Grip force of the first grasp, of all laws, and for good of the constant one, N. It holds 0.75 kg
at a friction of 0.3."""
LAG = 0.02
"""Time constant of the actuator, s."""
MARGIN = 1.2
"""Force of the all-knowing law over the least one."""
LOST_SLIDE = 0.005
"""Slide after the lift from which an object counts as lost, m."""
MAX_PRESSURE = 20e3
"""Range of the pads, Pa."""
WRIST_NOISE = 0.1
"""Standard deviation of the force that the wrist measures in a cycle, N."""
LEVER = 0.004
"""Height of the foam layer over which friction moves the centre of pressure, m."""
GRIP_NOISE = 0.05
"""Standard deviation of the grip force that the actuator measures, N. The pad's own sum is no
measure while the grip is eased: after a fall from 12 N, a hysteresis of 10 % still reads 1.2 N."""
CYCLE = STRIDE
"""Images per control cycle, and per judgement of the slip detector: 475 a second."""
ASSUMED_FRICTION = 0.3
"""Friction that counts where the pull found none."""
REGRIP = 1.3
"""Grip force right after the pull, over the least one."""
STICKING_SHARE = 1 / STATIC_RATIO
"""Sliding friction over the ratio at which an object stuck until the end of the pull."""
SLIDING_SECONDS = 0.08
"""Time after the pull in which alarms do not count, s. The object slides on until the grip has
risen, and the sensor reports it late: on seeds 8000-8019, 16 of 18 alarms came within 63 ms."""
PULL_START, PULL_SECONDS, SETTLE_SECONDS, TEST_SECONDS = 0.1, 1.0, 0.25, 1.2
"""Start and longest duration of the pull and lift, time until disturbances begin, and their
duration, s."""
PULL_SPEED, LIFT_SPEED, LIFT_SECONDS = 0.004, 0.1, 0.2
"""Speeds of the hand during the pull and the lift, m/s, and duration of the lift, s. At 1.5 mm/s
the pull finds static friction, which does not hold a sliding object."""
_TABLE_STIFFNESS, _TABLE_DAMPING = 5e3, 0.7
"""Stiffness of the table, N/m, and its damping as a share of the critical one."""


@dataclass(frozen=True)
class GripTrial:
    """One object and the disturbances after its lift."""

    held: HeldObject
    angle: float
    """Angle of the face, rad."""
    added: float
    """Added load, as a share of the weight."""
    rise: float
    """Time in which it is added, s."""
    start: float
    """Time of that after the disturbances begin, s."""
    shake: float
    """Acceleration of the hand, as a share of gravity."""
    frequency: float
    """Frequency of that, Hz."""

    def load(self, since: float) -> NDArray[np.float64]:
        """Return the load on the object, (2,), N, at a time after the disturbances begin."""
        weight = self.held.mass * GRAVITY
        if since <= 0:
            return np.array([0.0, -weight])
        share = min(max((since - self.start) / self.rise, 0.0), 1.0)
        swing = np.sin(2 * np.pi * self.frequency * since) * min(since / 0.1, 1.0)
        return np.array([0.0, -weight * (1 + self.added * share + self.shake * swing)])


@dataclass(frozen=True)
class GripResult:
    """How one law held one object."""

    lost: bool
    slide: float
    """Slide from the end of the lift on, m."""
    force_ratio: float
    """Mean grip force over the mean least force while disturbances act."""
    friction: float | None
    """Estimated over true friction, if the law estimates it."""


def draw_grip_trial(seed: int) -> GripTrial:
    """Draw an object that the first grip can hold, and its disturbances."""
    rng = np.random.default_rng((seed, 4))
    while True:
        mass = float(np.exp(rng.uniform(np.log(0.05), np.log(0.6))))
        friction = rng.uniform(0.3, 1.0)
        if mass * GRAVITY / (2 * friction) < 0.4 * FIRST_GRIP:
            break
    half_x, half_y = rng.uniform(0.012, 0.02, 2)
    curved = rng.random() < 0.5
    held = HeldObject(
        mass=mass,
        friction=friction,
        half_x=half_x,
        half_y=half_y,
        curve_x=1 / rng.uniform(0.03, 0.1) if curved else 0.0,
        centre_x=rng.uniform(-0.003, 0.003),
        centre_y=rng.uniform(-0.003, 0.003),
        roughness=rng.uniform(2e-6, 2e-5),
        friction_spread=rng.uniform(0.02, 0.1),
    )
    return GripTrial(
        held,
        float(rng.uniform(-np.pi, np.pi)),
        added=rng.uniform(0.0, 1.0),
        rise=rng.uniform(0.01, 0.06),
        start=rng.uniform(0.2, 0.6),
        shake=rng.uniform(0.0, 0.4),
        frequency=rng.uniform(1.0, 6.0),
    )


class _World:
    """The object in the grip above a table, and the lagging actuator."""

    def __init__(self, trial: GripTrial, sensor: SensorModel, seed: int):
        self.simulation = HeldSimulation(
            trial.held,
            FIRST_GRIP,
            max_pressure=MAX_PRESSURE,
            sensor=sensor,
            angle=trial.angle,
            pad=UNSEEN_PADS[seed % len(UNSEEN_PADS)],
            seed=seed,
        )
        self.trial = trial
        self.grip = self.command = FIRST_GRIP
        self.lift = 0.0
        """Height of the hand, m."""
        self.time = 0.0
        self._rest = self.simulation.place[1]
        self._height = 0.0
        self._damping = 2 * _TABLE_DAMPING * np.sqrt(_TABLE_STIFFNESS * trial.held.mass)
        self._sag = trial.held.mass * GRAVITY / _TABLE_STIFFNESS

    def cycle(self, since: float, speed: float, on_image: Callable[[], None] | None) -> None:
        """Advance by one control cycle; `speed` is that of the hand, m/s."""
        dt = 1 / IMAGE_RATE
        for _ in range(CYCLE):
            self.grip += (self.command - self.grip) * (1 - np.exp(-dt / LAG))
            self.lift += speed * dt
            force = self.trial.load(since)
            height = self.simulation.place[1] - self._rest + self.lift
            rate, self._height = (height - self._height) / dt, height
            if height < self._sag:
                push = _TABLE_STIFFNESS * (self._sag - height) - self._damping * rate
                force[1] += max(push, 0.0)
            self.simulation.advance(self.grip, (force[0], force[1]))
            self.time += dt
            since += dt if since > 0 else 0.0
            if on_image is not None:
                on_image()


def run_law(
    law: str,
    trial: GripTrial,
    seed: int,
    sensor: SensorModel,
    trained: SlipScore,
) -> GripResult:
    """Hold one object by one law.

    Parameters
    ----------
    law
        One of `LAWS`.
    trial
        The object and its disturbances.
    seed
        Source of surface, pad and noise. The detector is trained on other pads.
    sensor, trained
        Sensor model of the pads, and trained slip detector.
    """
    world = _World(trial, sensor, seed)
    rng = np.random.default_rng((seed, 5))
    senses = None if law in SENSELESS else _Senses(world, law, trained, rng)
    mu = trial.held.friction
    pulls = law.startswith("pull")
    pull = FrictionPull(FIRST_GRIP) if pulls else None
    control: GripLaw | None = SlipGrip(FIRST_GRIP) if law == "chapter" else None
    dt = CYCLE / IMAGE_RATE
    ready = PULL_START + PULL_SECONDS
    end = ready + SETTLE_SECONDS + TEST_SECONDS
    held_from = 0.0
    force = least = 0.0
    while world.time < end:
        since = world.time - ready - SETTLE_SECONDS
        lifting = PULL_START < world.time < ready
        raised = ready <= world.time < ready + LIFT_SECONDS
        speed = PULL_SPEED * lifting + LIFT_SPEED * raised
        world.cycle(since, speed, senses.image if senses else None)
        reading = senses.read() if senses else _NOTHING
        if law == "all-knowing":
            world.command = _all_knowing(trial, since)
        elif control is not None:
            world.command = control.update(reading, dt)
        elif pull is not None and lifting:
            world.command = pull.update(reading.normal, reading.tangential, dt)
            if pull.done:
                control = _after_pull(pull, reading)
        elif pull is not None and world.time >= ready:
            control = _after_pull(pull, reading)
        if since <= 0:
            held_from = world.simulation.slide
        else:
            force += world.grip
            least += float(np.linalg.norm(trial.load(since))) / (2 * mu)
    slide = world.simulation.slide - held_from
    found = control.friction if isinstance(control, LoadGrip) else None
    return GripResult(
        slide > LOST_SLIDE, slide, force / least, None if found is None else found / mu
    )


def _after_pull(pull: FrictionPull, reading: GripReading) -> LoadGrip:
    """Return the law that holds the object after the pull.

    An object that has not slid has at least the ratio at which it stuck.
    """
    friction = pull.friction or max(STICKING_SHARE * pull.ratio, ASSUMED_FRICTION)
    return LoadGrip(friction, REGRIP * reading.tangential / friction, pause=SLIDING_SECONDS)


def _all_knowing(trial: GripTrial, since: float) -> float:
    """Return the command of the law that knows load and friction, and inverts the actuator's lag.

    It does not know the future: the load's rate is that of the last cycle.
    """
    dt = CYCLE / IMAGE_RATE
    now = float(np.linalg.norm(trial.load(since)))
    rate = (now - float(np.linalg.norm(trial.load(since - dt)))) / dt
    return MARGIN * (now + LAG * max(rate, 0.0)) / (2 * trial.held.friction)


class _Senses:
    """What the pad and the wrist measure for one law."""

    def __init__(
        self, world: _World, law: str, trained: SlipScore, rng: np.random.Generator
    ) -> None:
        self._world, self._law, self._rng = world, law, rng
        simulation = world.simulation
        rows, columns = simulation.array.grid or (0, 0)
        self._state = SlipState(
            rows,
            columns,
            simulation.pitch,
            simulation.noise_floor,
            1 / IMAGE_RATE,
            simulation.shear_stiffness,
        )
        self._detector = SlipDetector(trained)
        self._pressures, self._shear = simulation.read()
        self._features = self._state.update(self._pressures, self._shear)
        self._centre: NDArray[np.float64] | None = None

    def image(self) -> None:
        """Take an image."""
        self._pressures, self._shear = self._world.simulation.read()
        self._features = self._state.update(self._pressures, self._shear)

    def read(self) -> GripReading:
        """Return the reading of this cycle."""
        world, simulation = self._world, self._world.simulation
        normal = world.grip + GRIP_NOISE * float(self._rng.standard_normal())
        area = simulation.pitch**2
        if self._law == "pull + lever":
            tangential = self._lever_load(area)
        elif self._law == "pull + shear":
            touching = self._pressures > 4 * simulation.noise_floor
            tangential = area * float(np.linalg.norm(self._shear[touching].sum(axis=0)))
        else:
            # The wrist bears both pads, and the weight of the object alone.
            force = 2 * simulation.friction_force + WRIST_NOISE * self._rng.standard_normal(2)
            tangential = 0.5 * float(np.linalg.norm(force))
        return GripReading(normal, tangential, slipping=self._detector.update(self._features))

    def _lever_load(self, area: float) -> float:
        """Return the tangential force, N, that the shift of the centre of pressure shows."""
        simulation = self._world.simulation
        pressures = self._pressures
        pressures = np.where(pressures > 4 * simulation.noise_floor, pressures, 0.0)
        total = max(float(pressures.sum()), 1e-9)
        centre = pressures @ simulation.array.positions[:, :2] / total
        if self._centre is None or self._world.time < PULL_START:
            self._centre = centre
        shift = float(np.linalg.norm(centre - self._centre))
        # The layer turns by its height, and the face itself moves as the layer bends.
        face = total**2 / max(float(pressures @ pressures), 1e-9) * area
        return shift / (LEVER / (total * area) + 1.0 / (simulation.shear_stiffness * face))


_NOTHING = GripReading(0.0, 0.0, slipping=False)
