"""A simulated world for servo tests: an arm with a lag moves a foam pad over a height field.

The world's z-axis points into the objects. The frame of a pad that lies flat is therefore parallel
to the world frame. Each sample of the pad is an independent spring (a Winkler foundation), in
series with the spring of the object.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
from scipy.spatial.transform import Rotation

from eyehand.tactile import ContactFeatures, TactileArray, TactileImage, contact_features

FOAM_PA_M = 2e6
"""Stiffness of the pad's foam, Pa/m: 1 kPa at half a millimetre."""
SPREAD_M = 0.0025
"""Standard deviation of the blur of the pressure in the foam, m."""
PAD = TactileArray.flat()
FINE = 2
"""Number of samples per tactel along each axis."""
DT = 0.004

Height = Callable[[np.ndarray, np.ndarray], np.ndarray]
"""Function from world x, y to the z of the object's surface, m. It is inf without surface."""


@dataclass
class World:
    """The pad, the arm and the object. ``step`` advances the world by one control cycle."""

    height: Height
    stiffness: float = 1e12
    """Stiffness of the object, Pa/m."""
    position: np.ndarray = field(default_factory=lambda: np.zeros(3))
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
        """Return the true pressures, (256,), Pa."""
        points = self.position + self.rotation.apply(self.samples)
        depth = np.maximum(points[:, 2] - self.height(points[:, 0], points[:, 1]), 0.0)
        spring = 1.0 / (1.0 / FOAM_PA_M + 1.0 / self.stiffness)
        bed = (spring * depth).reshape(16 * FINE, 16 * FINE)
        return (self.blur @ bed @ self.blur.T).ravel()

    def image(self) -> TactileImage:
        """Return the measured image. With noise, the pressures are quantised too."""
        pressures = self.pressures()
        if self.noise > 0.0:
            pressures = pressures + self.noise * self.rng.standard_normal(256)
            pressures = np.clip(np.round(pressures / 2.44) * 2.44, 0.0, 1e4)
        if self.dead is not None:
            pressures[self.dead] = 0.0
        return TactileImage(pressures, PAD)

    def features(self) -> ContactFeatures:
        """Return the contact features of the measured image."""
        return contact_features(self.image(), self.threshold)

    def force(self) -> float:
        """Return the true force between the pad and the object, N."""
        return float(self.pressures().sum() * PAD.area)

    def step(self, twist: np.ndarray, dt: float = DT) -> None:
        """Move the arm by the commanded twist for one cycle."""
        self.waiting.append(np.asarray(twist, float))
        command = self.waiting.pop(0)
        share = 1.0 - np.exp(-dt / self.lag) if self.lag > 0 else 1.0
        self.velocity = self.velocity + share * (command - self.velocity)
        self.position = self.position + self.rotation.apply(self.velocity[:3]) * dt
        if self.velocity[3:].any():
            self.rotation = self.rotation * Rotation.from_rotvec(self.velocity[3:] * dt)

    def tilt(self) -> float:
        """Return the angle between the pad's normal and the world's z-axis, degrees."""
        return float(np.degrees(np.arccos(np.clip(self.rotation.as_matrix()[2, 2], -1, 1))))


def box(half_x: float = 0.06, half_y: float = 0.06) -> Height:
    """Return the height field of a box with a flat top of the given half size, m."""

    def height(x, y):
        return np.where((np.abs(x) < half_x) & (np.abs(y) < half_y), 0.0, np.inf)

    return height


def ball(radius: float, x0: float = 0.0, y0: float = 0.0) -> Height:
    """Return the height field of a ball with its top at z = 0."""

    def height(x, y):
        rest = radius**2 - (x - x0) ** 2 - (y - y0) ** 2
        return np.where(rest > 0, radius - np.sqrt(np.maximum(rest, 0.0)), np.inf)

    return height


def rod(radius: float, angle: float, x0: float = 0.0, y0: float = 0.0) -> Height:
    """Return the height field of a straight rod along the direction ``angle``, rad."""

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
"""Height field and stiffness, Pa/m, of the rigid end of a pen, a stiff foam box and a soft ball."""
