"""A small world for servo tests: a foam pad that a lagging arm moves over a height field.

The world's z points into the objects, so that a pad that lies flat has the world's axes. Each
sample of the pad is a spring on its own (a Winkler bed), in series with the object's.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
from scipy.spatial.transform import Rotation

from eyehand.tactile import ContactFeatures, TactileArray, TactileImage, contact_features

FOAM_PA_M = 2e6
"""Pressure per depth of the pad's foam: 1 kPa at half a millimetre."""
SPREAD_M = 0.0025
"""Standard deviation with which the foam spreads pressure."""
PAD = TactileArray.flat()
FINE = 2
"""Samples per tactel and axis."""
DT = 0.004

Height = Callable[[np.ndarray, np.ndarray], np.ndarray]
"""World z of the object's surface over world x, y; inf where there is none."""


@dataclass
class World:
    """Pad, arm and object; ``step`` moves on by one control cycle."""

    height: Height
    stiffness: float = 1e12
    """Pressure per depth of the object itself, Pa/m."""
    place: np.ndarray = field(default_factory=lambda: np.zeros(3))
    rotation: Rotation = field(default_factory=Rotation.identity)
    lag: float = 0.015
    latency: int = 1
    noise: float = 0.0
    threshold: float = 10.0
    seed: int = 0
    dead: np.ndarray | None = None

    def __post_init__(self) -> None:
        self.rng = np.random.default_rng(self.seed)
        self.velocity = np.zeros(6)
        self.waiting = [np.zeros(6)] * self.latency
        axis = (np.arange(16 * FINE) - 0.5 * (16 * FINE - 1)) * 0.005 / FINE
        y, x = np.meshgrid(axis, axis, indexing="ij")
        self.samples = np.column_stack([x.ravel(), y.ravel(), np.zeros(x.size)])
        gaps = axis[:, None] - axis[None, :]
        spread = np.exp(-0.5 * (gaps / SPREAD_M) ** 2)
        spread /= spread.sum(axis=0)
        gather = np.kron(np.eye(16), np.full((1, FINE), 1.0 / FINE))
        self.blur = gather @ spread

    def pressures(self) -> np.ndarray:
        """True pressures, (256,), Pa."""
        there = self.place + self.rotation.apply(self.samples)
        depth = np.maximum(there[:, 2] - self.height(there[:, 0], there[:, 1]), 0.0)
        spring = 1.0 / (1.0 / FOAM_PA_M + 1.0 / self.stiffness)
        bed = (spring * depth).reshape(16 * FINE, 16 * FINE)
        return (self.blur @ bed @ self.blur.T).ravel()

    def image(self) -> TactileImage:
        """What the pad reads: with noise, quantised where there is noise."""
        pressures = self.pressures()
        if self.noise > 0.0:
            pressures = pressures + self.noise * self.rng.standard_normal(256)
            pressures = np.clip(np.round(pressures / 2.44) * 2.44, 0.0, 1e4)
        if self.dead is not None:
            pressures[self.dead] = 0.0
        return TactileImage(pressures, PAD)

    def features(self) -> ContactFeatures:
        """Features of what the pad reads."""
        return contact_features(self.image(), self.threshold)

    def force(self) -> float:
        """True force between pad and object, N."""
        return float(self.pressures().sum() * PAD.area)

    def step(self, twist: np.ndarray, dt: float = DT) -> None:
        """Let the arm follow the twist for one cycle."""
        self.waiting.append(np.asarray(twist, float))
        aim = self.waiting.pop(0)
        share = 1.0 - np.exp(-dt / self.lag) if self.lag > 0 else 1.0
        self.velocity = self.velocity + share * (aim - self.velocity)
        self.place = self.place + self.rotation.apply(self.velocity[:3]) * dt
        if self.velocity[3:].any():
            self.rotation = self.rotation * Rotation.from_rotvec(self.velocity[3:] * dt)

    def tilt(self) -> float:
        """Angle between the pad's normal and the world's z, degrees."""
        return float(np.degrees(np.arccos(np.clip(self.rotation.as_matrix()[2, 2], -1, 1))))


def box(half_x: float = 0.06, half_y: float = 0.06) -> Height:
    """A flat top of that half size."""

    def height(x, y):
        return np.where((np.abs(x) < half_x) & (np.abs(y) < half_y), 0.0, np.inf)

    return height


def ball(radius: float, x0: float = 0.0, y0: float = 0.0) -> Height:
    """A ball whose top is at z = 0."""

    def height(x, y):
        rest = radius**2 - (x - x0) ** 2 - (y - y0) ** 2
        return np.where(rest > 0, radius - np.sqrt(np.maximum(rest, 0.0)), np.inf)

    return height


def rod(radius: float, angle: float, x0: float = 0.0, y0: float = 0.0) -> Height:
    """A straight rod along the direction ``angle``."""

    def height(x, y):
        across = -np.sin(angle) * (x - x0) + np.cos(angle) * (y - y0)
        rest = radius**2 - across**2
        return np.where(rest > 0, radius - np.sqrt(np.maximum(rest, 0.0)), np.inf)

    return height


OBJECTS = {
    "pen": (ball(0.006), 1e12),
    "box": (box(), 5e6),
    "ball": (ball(0.04), 2e5),
}
"""Rigid pen's end, stiff foam box and soft ball: height field and own stiffness."""
