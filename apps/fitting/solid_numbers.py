"""Convert a solid to thirteen numbers for sliders, and back: mm, degrees, shape numbers."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import RigidTransform, Rotation

from eyehand.perception.superquadric import (
    MAX_EXPONENT,
    MAX_TAPER,
    MIN_EXPONENT,
    Kind,
    Superquadric,
)

MIN_SIZE_MM = 2.0
MAX_SIZE_RATIO = 2.5
"""Maximum extent on a slider, in largest extents of the solid or its cloud."""
MAX_MOVE_RATIO = 1.0
"""Maximum displacement on a slider, in largest extents."""
HALF_TURN_DEG = 180.0
SIZE_DIGITS, SHAPE_DIGITS = 2, 3
"""Decimals of sizes in mm, and of exponents and taper."""
TOLERANCE = 1e-9
"""Tolerance for rounding, of exponents and of semi-axes in m."""


@dataclass(frozen=True)
class SolidNumber:
    """One number of a solid with its slider range."""

    name: str
    """Name as in the covariance: a1 … k2."""
    label: str
    """Label with unit."""
    group: str
    """Slider group: size, shape, turn or move."""
    low: float
    """Minimum value."""
    high: float
    """Maximum value."""
    step: float
    """Step of the slider."""


def solid_numbers(largest_mm: float) -> tuple[SolidNumber, ...]:
    """Return all thirteen numbers, with ranges for a solid of about this largest extent, mm."""
    widest, far = (
        float(np.ceil(times * largest_mm / 10.0) * 10.0)
        for times in (MAX_SIZE_RATIO, MAX_MOVE_RATIO)
    )
    return (
        *(
            SolidNumber(f"a{k}", f"{axis}, mm", "size", MIN_SIZE_MM, widest, 0.1)
            for k, axis in enumerate("xyz", start=1)
        ),
        SolidNumber("eps1", "ε1 along z", "shape", MIN_EXPONENT, MAX_EXPONENT, 0.01),
        SolidNumber("eps2", "ε2 around z", "shape", MIN_EXPONENT, MAX_EXPONENT, 0.01),
        *(
            SolidNumber(f"k{k}", f"taper of {axis}", "shape", -MAX_TAPER, MAX_TAPER, 0.01)
            for k, axis in enumerate("xy", start=1)
        ),
        *(
            SolidNumber(f"r{axis}", f"about {axis}, °", "turn", -HALF_TURN_DEG, HALF_TURN_DEG, 0.5)
            for axis in "xyz"
        ),
        *(SolidNumber(f"c{axis}", f"along {axis}, mm", "move", -far, far, 0.1) for axis in "xyz"),
    )


def numbers_of(solid: Superquadric) -> dict[str, float]:
    """Return the rounded numbers of a solid at its own pose, with zero rotation and move."""
    return {
        **{f"a{k + 1}": round(2e3 * float(solid.semi_axes[k]), SIZE_DIGITS) for k in range(3)},
        "eps1": round(solid.exponents[0], SHAPE_DIGITS),
        "eps2": round(solid.exponents[1], SHAPE_DIGITS),
        "k1": round(solid.taper[0], SHAPE_DIGITS),
        "k2": round(solid.taper[1], SHAPE_DIGITS),
        **dict.fromkeys(("rx", "ry", "rz", "cx", "cy", "cz"), 0.0),
    }


def solid_of(numbers: Mapping[str, float], start: Superquadric) -> Superquadric:
    """Return the solid with these numbers. Rotation vector and move are in the axes of `start`."""
    turn = Rotation.from_rotvec([numbers[f"r{axis}"] for axis in "xyz"], degrees=True)
    move = np.array([numbers[f"c{axis}"] for axis in "xyz"]) * 1e-3
    own = RigidTransform.from_components(move, turn)
    semi_axes = np.array([numbers[f"a{k}"] for k in (1, 2, 3)]) * 0.5e-3
    exponents = (
        float(np.clip(numbers["eps1"], MIN_EXPONENT, MAX_EXPONENT)),
        float(np.clip(numbers["eps2"], MIN_EXPONENT, MAX_EXPONENT)),
    )
    taper = (numbers["k1"], numbers["k2"])
    kind = _kind(start, semi_axes, exponents, taper)
    return Superquadric(semi_axes, exponents, start.pose * own, kind, taper)


def _kind(
    start: Superquadric,
    semi_axes: NDArray[np.float64],
    exponents: tuple[float, float],
    taper: tuple[float, float],
) -> Kind:
    """Return the simplest name that describes the whole shape."""
    if any(taper):
        return "tapered"
    if start.kind == "tapered" or not np.allclose(
        exponents, start.exponents, rtol=0, atol=TOLERANCE
    ):
        return "superquadric"
    if start.kind == "sphere" and np.ptp(semi_axes) > TOLERANCE:
        return "ellipsoid"
    if start.kind == "cylinder" and abs(semi_axes[0] - semi_axes[1]) > TOLERANCE:
        return "superquadric"
    return start.kind
