"""Estimate the direction of a line-shaped contact by the Hough transform."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from eyehand.errors import InputError

from .image import TactileImage


@dataclass(frozen=True)
class HoughOptions:
    """Options of the Hough transform.

    Raises
    ------
    InputError
        If a value is out of its range.
    """

    angles: int = 180
    """Number of directions, >= 2. The time grows with it. A pad of 16 rows cannot distinguish more
    than about 60."""
    share: float = 0.5
    """Share of the region's highest pressure above which a tactel votes, 0..1. Low shares give a
    broad band of votes, in which the long diagonal wins; high shares leave few voters."""

    def __post_init__(self) -> None:
        if self.angles < 2:
            raise InputError(f"angles must be >= 2, got {self.angles}")
        if not 0 <= self.share < 1:
            raise InputError(f"share must be in 0..1, got {self.share}")


def hough_axis(
    image: TactileImage, region: NDArray[np.bool_], options: HoughOptions | None = None
) -> float:
    """Compute the direction of the line with the most tactels of a region.

    On a small grid, several lines often have the same number of votes. The result is then their
    mean direction, in the doubled angle.

    Parameters
    ----------
    image
        Calibrated tactile image of an array with an even grid.
    region
        Mask of the contact region, (N,).
    options
        Number of angles, and which tactels vote.

    Returns
    -------
    Angle in (-π/2, π/2] rad; 0 if no tactel votes, or all directions have the same votes.

    Raises
    ------
    InputError
        If the array has no grid.
    """
    options = options or HoughOptions()
    if image.array.grid is None:
        raise InputError("the Hough transform needs an array with an even grid; use moments")
    pressures = np.where(region, image.pressures, 0.0)
    voters = (pressures > options.share * pressures.max()).reshape(image.array.grid)
    normals = np.linspace(-np.pi / 2, np.pi / 2, options.angles, endpoint=False)
    rows, columns = np.nonzero(voters)
    if not rows.size:
        return 0.0
    # Lines x cos + y sin = distance, rounded half away from 0 to whole tactels.
    distances = np.outer(columns, np.cos(normals)) + np.outer(rows, np.sin(normals))
    lines = np.trunc(distances + np.copysign(0.5, distances)).astype(np.intp)
    lines -= lines.min()
    votes = np.bincount((lines * options.angles + np.arange(options.angles)).ravel())
    best = normals[np.flatnonzero(votes == votes.max()) % options.angles]
    # A line is perpendicular to its normal. In the doubled angle, that is a factor of -1.
    doubled = -np.exp(2j * best).sum()
    if abs(doubled) < 1e-9 * len(best):
        return 0.0
    angle = 0.5 * float(np.angle(doubled))
    return np.pi / 2 if angle <= -np.pi / 2 else angle
