"""An object held between two equal pads, loaded and read at the pads' image rate."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass, fields
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from eyehand.errors import InputError
from eyehand.tactile import Calibration, TactileArray, calibrate

from .calibration_bench import run_bench
from .foam import Foam, pressure_table
from .foam_column import CELLS_PER_TACTEL, SHEAR_STIFFNESS
from .held_kernels import (
    ANGLE,
    DEPTH,
    MOTION_SIZE,
    PUSH,
    SLIDE,
    SLIPPING,
    HeldBody,
    X,
    Y,
    advance_held,
)
from .layer_shear import base_forces
from .sensor_memory import SensorMemory
from .sensor_model import SENSORS, SensorModel
from .tactel_spread import POINT_SPREAD_M, spread_to_tactels, spread_weights
from .tactile_pad import IMAGE_RATE, LOSS_TIME_S, SHEAR_SHARE
from .tactile_readout import FULL_SCALE

DEFAULT_RANGE = 10e3
"""Range of the default pad, Pa. A pad of another range has a foam and tactels scaled by it."""
_ROWS, _PITCH = 16, 0.005
_STEPS = 4
"""Steps per image. The stiffest grip of a light object then takes 30 steps per oscillation."""
_TEXTURE_CELLS, _TEXTURE_PERIOD = 256, 0.064
"""Entries and period, m, of the surface's roughness."""
_WAVES = (0.0015, 0.012)
"""Shortest and longest wave of the roughness, m; all waves have equal power per octave."""


@dataclass(frozen=True)
class HeldObject:
    """An object between two pads.

    Raises
    ------
    InputError
        If a value is out of range.
    """

    mass: float = 0.2
    """kg."""
    friction: float = 0.6
    """Mean sliding friction; static friction is 1.2 times that."""
    half_x: float = 0.015
    """Half the face's extent along the object's x, m."""
    half_y: float = 0.015
    """Along y, m."""
    curve_x: float = 0.0
    """Curvature of the face along x, 1/m; 0 is flat."""
    curve_y: float = 0.0
    """Along y, 1/m."""
    centre_x: float = 0.0
    """Centre of mass from the middle of the face, along x, m."""
    centre_y: float = 0.0
    """Along y, m."""
    gyration: float = 0.03
    """Radius of gyration about the pads' normal, m."""
    roughness: float = 10e-6
    """Standard deviation of the surface's height, m."""
    friction_spread: float = 0.05
    """Standard deviation of the friction over the surface, as a share of its mean."""

    def __post_init__(self) -> None:
        for item in fields(self):
            value = getattr(self, item.name)
            signed = item.name in ("centre_x", "centre_y")
            if not np.isfinite(value) or (value < 0 and not signed):
                raise InputError(f"{item.name} must be finite and >= 0, got {value}")
        if min(self.mass, self.half_x, self.half_y, self.gyration) <= 0:
            raise InputError(
                "mass, extents and gyration must be > 0, got "
                f"{self.mass} kg, {self.half_x}, {self.half_y} and {self.gyration} m"
            )

    def body(self, rng: np.random.Generator) -> HeldBody:
        """Draw the surface, and return the object as the kernel reads it."""
        height = self.roughness * _rough_surface(rng)
        factor = np.maximum(1.0 + self.friction_spread * _rough_surface(rng), 0.2)
        return HeldBody(
            self.mass,
            self.mass * self.gyration**2,
            self.centre_x,
            self.centre_y,
            self.half_x,
            self.half_y,
            self.curve_x,
            self.curve_y,
            np.ascontiguousarray([height, factor]),
            _TEXTURE_PERIOD / _TEXTURE_CELLS,
        )


class HeldSimulation:
    """Two pads that hold an object, and the readings of one of them.

    Parameters
    ----------
    held
        The object.
    grip
        First grip force, N, > 0.
    max_pressure
        Range of the pad, Pa: the foam's modulus and the tactels' curves scale with it.
    sensor
        Sensor model; its wait and noise also hold for the shear that an array with shear reads.
        Friction always holds at rest, and always moves the image.
    angle
        Angle of the face, rad.
    pad
        Number of the pad: source of its electronics, >= 0. Each pad is calibrated once.
    seed
        Source of the surface and the noise.

    Raises
    ------
    InputError
        If the grip force or the range is not positive.
    """

    array = TactileArray.flat(_ROWS, _ROWS, _PITCH)
    """Geometry of the tactels."""
    pitch = _PITCH
    """Distance of two tactels, m."""

    def __init__(
        self,
        held: HeldObject,
        grip: float,
        *,
        max_pressure: float = 20e3,
        sensor: SensorModel | None = None,
        angle: float = 0.0,
        pad: int = 0,
        seed: int = 0,
    ) -> None:
        if not (0 < grip < np.inf and 0 < max_pressure < np.inf):
            raise InputError(f"grip and range must be > 0, got {grip} N and {max_pressure} Pa")
        self._rng = np.random.default_rng((seed, 3))
        self._body = held.body(self._rng)
        self._scale = max_pressure / DEFAULT_RANGE
        default = Foam()
        foam = Foam(default.thickness, default.modulus * self._scale, default.densification)
        half = 0.5 * _ROWS * _PITCH
        stiffness = SHEAR_SHARE * foam.modulus / foam.thickness
        self._bed = np.array(
            [half, half, foam.thickness, LOSS_TIME_S, held.friction, 0.0, stiffness]
        )
        table = pressure_table(foam)
        self._period = 1.0 / IMAGE_RATE
        self._law = (table.pressures, table.step, self._period / _STEPS)
        cells = CELLS_PER_TACTEL * _ROWS
        self._grid = np.zeros((3, cells, cells))
        self._base = np.zeros_like(self._grid)
        self._bends = np.zeros((3, cells, cells))
        self._weights = spread_weights(_ROWS, _PITCH, POINT_SPREAD_M)
        count = _ROWS * _ROWS
        self._pressures, self._shear = np.zeros(count), np.zeros((count, 2))
        self._sensor = sensor or SENSORS["good"]
        readout = self._sensor.readout(count, pad)
        self._memory = SensorMemory(self._sensor, readout, pad)
        self._calibration = _calibration(self._sensor, pad)
        self._lever = foam.thickness
        self._waiting: deque[tuple[float, NDArray[np.float64]]] = deque()
        self.time = 0.0
        self._drive = np.zeros((2, 4))
        self._drive[:, 0] = grip
        self._motion = np.zeros(MOTION_SIZE)
        cosine, sine = np.cos(angle), np.sin(angle)
        self._motion[X] = cosine * held.centre_x - sine * held.centre_y
        self._motion[Y] = sine * held.centre_x + cosine * held.centre_y
        self._motion[ANGLE] = angle
        self._press_in(foam.thickness)

    @property
    def shear_stiffness(self) -> float:
        """Shear stiffness of the foam layer, Pa/m."""
        return float(self._bed[SHEAR_STIFFNESS])

    @property
    def slide(self) -> float:
        """True path that the face has slid over the foam, m: the mean over the cells by force."""
        return float(self._motion[SLIDE])

    @property
    def slipping(self) -> float:
        """True share of the normal force on cells that slide, 0..1."""
        return float(self._motion[SLIPPING])

    @property
    def place(self) -> NDArray[np.float64]:
        """True place of the centre of mass on the pad, (2,), m."""
        return self._motion[[X, Y]]

    @property
    def angle(self) -> float:
        """True angle of the face, rad."""
        return float(self._motion[ANGLE])

    @property
    def friction_force(self) -> NDArray[np.float64]:
        """True friction of one pad on the object, (2,), N."""
        return -self._grid[1:].sum(axis=(1, 2))

    @property
    def noise_floor(self) -> float:
        """Standard deviation of a pressure reading of the linear range, Pa."""
        return max(self._sensor.noise, 0.5) / FULL_SCALE * DEFAULT_RANGE * self._scale

    def advance(self, grip: float, force: tuple[float, float], torque: float = 0.0) -> None:
        """Advance time by one image; grip force and load change linearly to the given values.

        Parameters
        ----------
        grip
            Normal force on each pad, N, >= 0.
        force
            Load on the object at its centre of mass, along the pad's x and y, N. It holds weight
            and inertia in the frame of the hand.
        torque
            Load about the pads' normal, N m.
        """
        self._drive[0] = self._drive[1]
        self._drive[1] = (max(grip, 0.0), force[0], force[1], torque)
        advance_held(
            self._body,
            self._law,
            self._bed,
            self._drive,
            _STEPS,
            self._motion,
            self._grid,
            self._bends,
        )
        self.time += self._period

    def read(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Take an image, and return the pressures (N,) and shear stresses (N, 2) that arrive, Pa.

        The pressures pass the electronics and their calibration. Call it once per image.
        """
        cell = _PITCH / CELLS_PER_TACTEL
        base_forces(self._grid, self._lever, cell, cell, self._base)
        spread_to_tactels(
            self._base, self._weights, self._weights, _PITCH**2, self._pressures, self._shear
        )
        scaled = np.maximum(self._pressures, 0.0) / self._scale
        raw = self._memory.read(self.time, scaled, self._rng)
        noise = self.noise_floor * self._rng.standard_normal(self._shear.shape)
        self._waiting.append((self.time, self._shear + noise))
        due = self.time - self._sensor.wait + 0.5 * self._period
        while len(self._waiting) > 1 and self._waiting[1][0] <= due:
            self._waiting.popleft()
        return self._calibration.to_pressure(raw) * self._scale, self._waiting[0][1]

    def _press_in(self, thickness: float) -> None:
        """Find the depth at which the unloaded face bears the first grip force."""
        still = np.zeros(MOTION_SIZE)
        still[: DEPTH + 1] = self._motion[: DEPTH + 1]
        goal = self._drive[1].copy()
        low, high = 0.0, 0.0
        for high in np.linspace(0.0, thickness, 33)[1:]:
            still[DEPTH] = high
            if self._push_at(still) >= goal[0]:
                break
        for _ in range(30):
            middle = 0.5 * (low + high)
            still[DEPTH] = middle
            low, high = (low, middle) if self._push_at(still) > goal[0] else (middle, high)
        self._motion[DEPTH] = high
        self._bends[:] = 0.0

    def _push_at(self, motion: NDArray[np.float64]) -> float:
        trial = motion.copy()
        unloaded = np.zeros((2, 4))
        advance_held(
            self._body,
            (*self._law[:2], 0.0),
            self._bed,
            unloaded,
            1,
            trial,
            self._grid,
            self._bends,
        )
        return float(trial[PUSH])


@lru_cache
def _calibration(sensor: SensorModel, seed: int) -> Calibration:
    return calibrate(run_bench(sensor.readout(_ROWS * _ROWS, seed), seed=seed))


def _rough_surface(rng: np.random.Generator) -> NDArray[np.float64]:
    """Return a periodic random surface of standard deviation 1, (n, n)."""
    frequencies = np.fft.fftfreq(_TEXTURE_CELLS, _TEXTURE_PERIOD / _TEXTURE_CELLS)
    radius = np.hypot(frequencies[:, None], frequencies)
    kept = (radius > 1 / _WAVES[1]) & (radius < 1 / _WAVES[0])
    # Equal power per octave of a plane's waves falls with the square of the frequency.
    amplitude = np.divide(1.0, radius, out=np.zeros_like(radius), where=kept)
    noise = np.fft.fft2(rng.standard_normal(radius.shape))
    surface = np.fft.ifft2(noise * amplitude).real
    return surface / surface.std()
