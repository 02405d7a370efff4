"""Stress sweeps over harder solids and views: one face, sharp edges, rods, sheets, wires."""

from __future__ import annotations

import functools
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
from scipy.spatial.transform import RigidTransform, Rotation

from eyehand.perception import Superquadric

from ...bench import Sweep, Trial
from .cloud_sweeps import MM, accuracy_sweeps
from .clouds import DISTANCE, POINTS
from .rendered_clouds import random_rotation, view_direction
from .stress_trial import FitCallable, try_fit, try_shapeless_points
from .stress_views import CloudView, one_view

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    from eyehand.perception.superquadric import Kind

    from .cloud_sweeps import SweepRow

EDGE = 0.1
"""Exponent of sharp edges."""
SEMI_AXES = (0.025, 0.06)
"""Range of the semi-axes of boxes and of solids with other exponents, m."""
LONGEST = 0.1
"""Maximum semi-axis of rods and plates, m."""
HALF_LENGTH = 0.05
"""Half side of a sheet, and half length of a wire, m."""
MIN_SLANT = 0.25
"""Minimum cosine between a slanting view and each axis of the solid."""
ASPECTS = (1, 2, 3, 5, 7, 10, 15, 20)
CORNER = np.ones(3) / np.sqrt(3)
"""Direction from which a view shows three faces of a box alike."""


def solid_sweeps() -> tuple[Sweep[FitCallable], ...]:
    """Return the sweeps of the angle of view, exponents, aspect ratios, sheets and wires."""
    face, end = (55, 45, 35, 25, 20, 15, 10, 5, 0), (45, 35, 25, 20, 15, 10, 5, 0)
    side, above = (45, 55, 65, 70, 75, 80, 85, 90), (30, 45, 60, 70, 75, 80, 85, 90)
    rows = (
        ("face-on", "angle between view and face normal of a box", "°", face, 15, _box_view),
        ("end-on", "angle between view and axis of a cylinder", "°", end, 5, _cylinder_view),
        ("side-on", "angle between view and axis of a cylinder", "°", side, 90, _cylinder_view),
        ("from-above", "elevation of the view of a box on a table", "°", above, 90, _from_above),
        *_exponent_rows(),
        ("rod", "length of a rod, times its thickness", "", ASPECTS, 10, _rod),
        ("plate", "width of a plate, times its thickness", "", ASPECTS, 7, _plate),
    )
    return (
        *accuracy_sweeps(rows),
        *(
            Sweep(
                name=name,
                axis=f"noise of a {shape} of {2e3 * HALF_LENGTH:.0f} mm",
                unit="mm",
                values=(0, 0.01, 0.1, 0.3, 0.5, 1, 2, 3, 5),
                holds_to=holds_to,
                attempt=attempt,
                right="refused, or a solid no larger than the points",
            )
            for name, shape, holds_to, attempt in (
                ("sheet", "bare sheet", 5, _sheet),
                ("wire", "straight wire", 0.5, _wire),
            )
        ),
    )


def _exponent_rows() -> list[SweepRow]:
    sharper = (1, 0.7, 0.5, 0.3, 0.2, 0.1, 0.05)
    pointed = (1, 1.3, 1.5, 1.7, 1.8, 1.9, 1.95)
    pairs = (
        ("sharp", "both exponents, from round to box", sharper, lambda e: (e, e)),
        ("pinched", "both exponents, from round to octahedron", pointed, lambda e: (e, e)),
        ("diamond", "ε1, with ε2 = 2 - ε1: a prism on a diamond", sharper, lambda e: (e, 2 - e)),
        ("tent", "ε2, with ε1 = 2 - ε2: two pyramids", sharper, lambda e: (2 - e, e)),
    )
    return [
        (name, axis, "", values, values[-1], functools.partial(_exponents, pair))
        for name, axis, values, pair in pairs
    ]


def random_solid(
    semi_axes: NDArray[np.float64],
    exponents: tuple[float, float],
    rng: np.random.Generator,
    kind: Kind = "superquadric",
) -> Superquadric:
    """Return a solid near the origin with a random rotation."""
    turn = random_rotation(rng)
    pose = RigidTransform.from_components(rng.uniform(-0.2, 0.2, 3), turn)
    return Superquadric(semi_axes, exponents, pose, kind)


def _box_view(angle_deg: float, seed: int, method: FitCallable) -> Trial:
    rng = _rng(seed, 1)
    solid = random_solid(rng.uniform(*SEMI_AXES, 3), (EDGE, EDGE), rng, "box")
    diagonal = CORNER * [1.0, 1.0, 0.0]
    diagonal /= np.linalg.norm(diagonal)
    return _fit_view(solid, angle_deg, diagonal, rng, seed, method)


def _cylinder_view(angle_deg: float, seed: int, method: FitCallable) -> Trial:
    rng = _rng(seed, 2)
    radius, half_height = rng.uniform(0.02, 0.045), rng.uniform(0.03, 0.08)
    semi_axes = np.array([radius, radius, half_height])
    solid = random_solid(semi_axes, (EDGE, 1.0), rng, "cylinder")
    return _fit_view(solid, angle_deg, np.array([1.0, 0.0, 0.0]), rng, seed, method)


def _fit_view(
    solid: Superquadric,
    angle_deg: float,
    across: NDArray[np.float64],
    rng: np.random.Generator,
    seed: int,
    method: FitCallable,
) -> Trial:
    """Fit the view of a solid at an angle from its z-axis, in the direction `across`."""
    angle = np.radians(angle_deg)
    towards = np.cos(angle) * np.array([0.0, 0.0, 1.0]) + np.sin(angle) * across
    return try_fit(method, one_view(solid, solid.to_parent(DISTANCE * towards), rng), seed)


def _from_above(elevation_deg: float, seed: int, method: FitCallable) -> Trial:
    rng = _rng(seed, 3)
    half = rng.uniform(*SEMI_AXES, 3)
    turn = Rotation.from_euler("z", rng.uniform(0, 2 * np.pi))
    pose = RigidTransform.from_components([*rng.uniform(-0.2, 0.2, 2), half[2]], turn)
    solid = Superquadric(half, (EDGE, EDGE), pose, "box")
    towards = view_direction(rng.uniform(0, 2 * np.pi), np.radians(elevation_deg))
    view = one_view(solid, solid.centre + DISTANCE * towards, rng)
    table = np.array([0.0, 0.0, 1.0, 0.0])
    return try_fit(method, replace(view, support_plane=table), seed)


def _exponents(
    pair: Callable[[float], tuple[float, float]], value: float, seed: int, method: FitCallable
) -> Trial:
    rng = _rng(seed, 4)
    solid = random_solid(rng.uniform(*SEMI_AXES, 3), pair(value), rng)
    return _fit_slanting_view(solid, rng, seed, method)


def _rod(aspect: float, seed: int, method: FitCallable) -> Trial:
    rng = _rng(seed, 5)
    half = np.array([LONGEST / aspect, LONGEST / aspect, LONGEST])
    return _fit_slanting_view(random_solid(half, _bar_exponents(rng), rng), rng, seed, method)


def _plate(aspect: float, seed: int, method: FitCallable) -> Trial:
    rng = _rng(seed, 6)
    half = np.array([LONGEST, LONGEST, LONGEST / aspect])
    return _fit_slanting_view(random_solid(half, _bar_exponents(rng), rng), rng, seed, method)


def _bar_exponents(rng: np.random.Generator) -> tuple[float, float]:
    """Draw the exponents of a round, a square or a rounded bar."""
    choices = ((EDGE, 1.0), (EDGE, EDGE), (0.5, 0.5))
    return choices[int(rng.integers(len(choices)))]


def _fit_slanting_view(
    solid: Superquadric, rng: np.random.Generator, seed: int, method: FitCallable
) -> Trial:
    """Fit a random view that shows three sides of a solid. Views of one face are another sweep."""
    towards = np.zeros(3)
    while np.abs(towards).min() < MIN_SLANT:
        towards = rng.normal(size=3)
        towards /= np.linalg.norm(towards)
    return try_fit(method, one_view(solid, solid.to_parent(DISTANCE * towards), rng), seed)


def _sheet(sigma_mm: float, seed: int, method: FitCallable) -> Trial:
    rng = _rng(seed, 7)
    flat = np.column_stack([rng.uniform(-HALF_LENGTH, HALF_LENGTH, (POINTS, 2)), np.zeros(POINTS)])
    return _fit_shapeless(flat, sigma_mm, rng, method)


def _wire(sigma_mm: float, seed: int, method: FitCallable) -> Trial:
    rng = _rng(seed, 8)
    straight = rng.uniform(-HALF_LENGTH, HALF_LENGTH, (POINTS, 1)) * [1.0, 0.0, 0.0]
    return _fit_shapeless(straight, sigma_mm, rng, method)


def _fit_shapeless(
    points: NDArray[np.float64], sigma_mm: float, rng: np.random.Generator, method: FitCallable
) -> Trial:
    """Fit points (N, 3) of no solid, with noise and at a random pose."""
    points = points + sigma_mm * MM * rng.normal(size=points.shape)
    T = RigidTransform.from_components(rng.uniform(-0.2, 0.2, 3), random_rotation(rng))
    view = CloudView(T.apply(points), None, T.apply([0.0, 0.0, DISTANCE]))
    return try_shapeless_points(method, view)


def _rng(seed: int, sweep: int) -> np.random.Generator:
    return np.random.default_rng([seed, 31, sweep])
