"""Sweeps in which solids and views get harder: face-on, sharp, long, flat, no solid at all."""

from __future__ import annotations

import functools
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
from scipy.spatial.transform import RigidTransform, Rotation

from eyehand.perception import Superquadric

from ...bench import Sweep, Trial
from .cloud_sweeps import FINE, MM
from .clouds import DISTANCE, POINTS
from .stress_trial import FitCallable, try_fit, try_nothing_made_up
from .stress_views import Look, one_view

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    from eyehand.perception.superquadric import Kind

EDGE = 0.1
"""Exponent of sharp edges."""
LONGEST = 0.1
"""Maximum semi-axis of rods and plates, m."""
SHEET = 0.05
"""Half a sheet's side, and half a wire's length, m."""
LEAST_SLANT = 0.25
"""Cosine between a slanting view and each axis of what it shows, at least."""
ASPECTS = (1, 2, 3, 5, 7, 10, 15, 20)
CORNER = np.ones(3) / np.sqrt(3)
"""Where a box shows three faces alike."""


def solid_sweeps() -> tuple[Sweep[FitCallable], ...]:
    """Sweeps of the angle of view, exponents, aspect ratios, sheets and wires."""
    return (
        *_view_sweeps(),
        *_exponent_sweeps(),
        Sweep(
            name="rod",
            axis="length of a rod, times its thickness",
            unit="",
            values=ASPECTS,
            holds_to=10,
            attempt=_rod,
            right=FINE,
        ),
        Sweep(
            name="plate",
            axis="width of a plate, times its thickness",
            unit="",
            values=ASPECTS,
            holds_to=7,
            attempt=_plate,
            right=FINE,
        ),
        Sweep(
            name="sheet",
            axis=f"noise of a bare sheet of {2e3 * SHEET:.0f} mm",
            unit="mm",
            values=(0, 0.01, 0.1, 0.3, 0.5, 1, 2, 3, 5),
            holds_to=5,
            attempt=_sheet,
            right="refused, or a solid no larger than the points",
        ),
        Sweep(
            name="wire",
            axis=f"noise of a straight wire of {2e3 * SHEET:.0f} mm",
            unit="mm",
            values=(0, 0.01, 0.1, 0.3, 0.5, 1, 2, 3, 5),
            holds_to=0.5,
            attempt=_wire,
            right="refused, or a solid no larger than the points",
        ),
    )


def _view_sweeps() -> tuple[Sweep[FitCallable], ...]:
    return (
        Sweep(
            name="face-on",
            axis="view of a box, from its corner to its face",
            unit="°",
            values=(55, 45, 35, 25, 20, 15, 10, 5, 0),
            holds_to=15,
            attempt=_face_on,
            right=FINE,
        ),
        Sweep(
            name="end-on",
            axis="view of a cylinder, from slanting to its end",
            unit="°",
            values=(45, 35, 25, 20, 15, 10, 5, 0),
            holds_to=5,
            attempt=_can,
            right=FINE,
        ),
        Sweep(
            name="side-on",
            axis="view of a cylinder, from slanting to its side",
            unit="°",
            values=(45, 55, 65, 70, 75, 80, 85, 90),
            holds_to=90,
            attempt=_can,
            right=FINE,
        ),
        Sweep(
            name="from-above",
            axis="view of a box on a table, to straight down",
            unit="°",
            values=(30, 45, 60, 70, 75, 80, 85, 90),
            holds_to=90,
            attempt=_from_above,
            right=FINE,
        ),
    )


def _exponent_sweeps() -> tuple[Sweep[FitCallable], ...]:
    sharper = (1, 0.7, 0.5, 0.3, 0.2, 0.1, 0.05)
    return (
        Sweep(
            name="sharp",
            axis="both exponents, from round to box",
            unit="",
            values=sharper,
            holds_to=0.05,
            attempt=functools.partial(_exponents, lambda e: (e, e)),
            right=FINE,
        ),
        Sweep(
            name="pinched",
            axis="both exponents, from round to octahedron",
            unit="",
            values=(1, 1.3, 1.5, 1.7, 1.8, 1.9, 1.95),
            holds_to=1.95,
            attempt=functools.partial(_exponents, lambda e: (e, e)),
            right=FINE,
        ),
        Sweep(
            name="diamond",
            axis="ε1, with ε2 = 2 - ε1: a prism on a diamond",
            unit="",
            values=sharper,
            holds_to=0.05,
            attempt=functools.partial(_exponents, lambda e: (e, 2 - e)),
            right=FINE,
        ),
        Sweep(
            name="tent",
            axis="ε2, with ε1 = 2 - ε2: two pyramids",
            unit="",
            values=sharper,
            holds_to=0.05,
            attempt=functools.partial(_exponents, lambda e: (2 - e, e)),
            right=FINE,
        ),
    )


def posed(
    semi_axes: NDArray[np.float64],
    exponents: tuple[float, float],
    rng: np.random.Generator,
    kind: Kind = "superquadric",
) -> Superquadric:
    """A solid, anyhow turned, near the origin."""
    turn = Rotation.from_quat(rng.normal(size=4))
    pose = RigidTransform.from_components(rng.uniform(-0.2, 0.2, 3), turn)
    return Superquadric(semi_axes, exponents, pose, kind)


def _face_on(angle: float, seed: int, method: FitCallable) -> Trial:
    rng = _random(seed, 1)
    solid = posed(rng.uniform(0.025, 0.06, 3), (EDGE, EDGE), rng, "box")
    across = CORNER - [0.0, 0.0, CORNER[2]]
    across /= np.linalg.norm(across)
    return _viewed(solid, np.radians(angle), across, rng, seed, method)


def _can(angle: float, seed: int, method: FitCallable) -> Trial:
    rng = _random(seed, 2)
    radius, height = rng.uniform(0.02, 0.045), rng.uniform(0.03, 0.08)
    solid = posed(np.array([radius, radius, height]), (EDGE, 1.0), rng, "cylinder")
    return _viewed(solid, np.radians(angle), np.array([1.0, 0.0, 0.0]), rng, seed, method)


def _viewed(
    solid: Superquadric,
    angle: float,
    across: NDArray[np.float64],
    rng: np.random.Generator,
    seed: int,
    method: FitCallable,
) -> Trial:
    """View a solid at an angle from its z-axis, towards `across`."""
    towards = np.cos(angle) * np.array([0.0, 0.0, 1.0]) + np.sin(angle) * across
    return try_fit(method, one_view(solid, solid.to_parent(DISTANCE * towards), rng), seed)


def _from_above(elevation: float, seed: int, method: FitCallable) -> Trial:
    rng = _random(seed, 3)
    half = rng.uniform(0.025, 0.06, 3)
    turn = Rotation.from_euler("z", rng.uniform(0, 2 * np.pi))
    pose = RigidTransform.from_components([*rng.uniform(-0.2, 0.2, 2), half[2]], turn)
    solid = Superquadric(half, (EDGE, EDGE), pose, "box")
    up, aside = np.radians(elevation), rng.uniform(0, 2 * np.pi)
    towards = [np.cos(up) * np.cos(aside), np.cos(up) * np.sin(aside), np.sin(up)]
    look = one_view(solid, solid.centre + DISTANCE * np.array(towards), rng)
    table = np.array([0.0, 0.0, 1.0, 0.0])
    return try_fit(method, replace(look, support_plane=table), seed)


def _exponents(
    pair: Callable[[float], tuple[float, float]], value: float, seed: int, method: FitCallable
) -> Trial:
    rng = _random(seed, 4)
    return _anyhow(posed(rng.uniform(0.025, 0.06, 3), pair(value), rng), rng, seed, method)


def _rod(aspect: float, seed: int, method: FitCallable) -> Trial:
    rng = _random(seed, 5)
    thick = LONGEST / aspect
    return _anyhow(posed(np.array([thick, thick, LONGEST]), _edges(rng), rng), rng, seed, method)


def _plate(aspect: float, seed: int, method: FitCallable) -> Trial:
    rng = _random(seed, 6)
    half = np.array([LONGEST, LONGEST, LONGEST / aspect])
    return _anyhow(posed(half, _edges(rng), rng), rng, seed, method)


def _edges(rng: np.random.Generator) -> tuple[float, float]:
    """Exponents of a round bar, of a square one, or of something between."""
    choices = ((EDGE, 1.0), (EDGE, EDGE), (0.5, 0.5))
    return choices[int(rng.integers(len(choices)))]


def _anyhow(solid: Superquadric, rng: np.random.Generator, seed: int, method: FitCallable) -> Trial:
    """View a solid from anywhere that shows three of its sides: face-on is a sweep of its own."""
    towards = np.zeros(3)
    while np.abs(towards).min() < LEAST_SLANT:
        towards = rng.normal(size=3)
        towards /= np.linalg.norm(towards)
    look = one_view(solid, solid.to_parent(DISTANCE * towards), rng)
    return try_fit(method, look, seed)


def _sheet(sigma: float, seed: int, method: FitCallable) -> Trial:
    rng = _random(seed, 7)
    flat = np.column_stack([rng.uniform(-SHEET, SHEET, (POINTS, 2)), np.zeros(POINTS)])
    return _no_solid(flat, sigma * MM, rng, method)


def _wire(sigma: float, seed: int, method: FitCallable) -> Trial:
    rng = _random(seed, 8)
    straight = rng.uniform(-SHEET, SHEET, (POINTS, 1)) * [1.0, 0.0, 0.0]
    return _no_solid(straight, sigma * MM, rng, method)


def _no_solid(
    points: NDArray[np.float64], noise: float, rng: np.random.Generator, method: FitCallable
) -> Trial:
    points = points + noise * rng.normal(size=points.shape)
    origin = np.array([0.0, 0.0, DISTANCE])
    T = RigidTransform.from_components(
        rng.uniform(-0.2, 0.2, 3), Rotation.from_quat(rng.normal(size=4))
    )
    look = Look(T.apply(points), None, T.apply(origin))
    return try_nothing_made_up(method, look)


def _random(seed: int, sweep: int) -> np.random.Generator:
    return np.random.default_rng([seed, 31, sweep])
