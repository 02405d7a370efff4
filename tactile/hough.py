"""The direction of a line-shaped contact by the Hough transform, as the paper has it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from eyehand.errors import InputError

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from .image import TactileImage


@dataclass(frozen=True)
class HoughOptions:
    """Settings of the Hough transform.

    Raises
    ------
    InputError
        If a value is out of its range.
    """

    angles: int = 180
    """Directions that are voted for, >= 2: time grows with them, and from about 60 on a pad of
    16 rows cannot tell them apart."""
    share: float = 0.5
    """Tactels above this share of the region's highest pressure vote, 0..1: low ones make a broad
    band of votes, in which the long diagonal wins; high ones leave few voters."""

    def __post_init__(self) -> None:
        if self.angles < 2:
            raise InputError(f"angles must be >= 2, got {self.angles}")
        if not 0 <= self.share < 1:
            raise InputError(f"share must be in 0..1, got {self.share}")


def hough_axis(
    image: TactileImage, region: NDArray[np.bool_], options: HoughOptions | None = None
) -> float:
    """Find the direction of the line that most of a region's tactels lie on.

    Of several lines with as many votes, which are common on a small grid, the mean direction
    counts (in the doubled angle).

    Parameters
    ----------
    image
        Calibrated tactile image of an array with an even grid.
    region
        Tactels of the contact, (N,).

    Returns
    -------
    Angle in (-π/2, π/2] rad; 0 where no tactel votes, or all directions get the same votes.

    Raises
    ------
    InputError
        If the array has no grid.
    """
    # scikit-image needs 0.2 s to load, and moments do without it.
    from skimage.transform import hough_line

    options = options or HoughOptions()
    if image.array.grid is None:
        raise InputError("the Hough transform needs an array with an even grid; use moments here")
    felt = np.where(region, image.pressures, 0.0)
    voters = (felt > options.share * felt.max()).reshape(image.array.grid)
    normals = np.linspace(-np.pi / 2, np.pi / 2, options.angles, endpoint=False)
    votes, directions, _ = hough_line(voters, theta=normals)
    best = directions[np.nonzero(votes == votes.max())[1]]
    # Directions of normals: the line's own are a right angle further, -1 in the doubled angle.
    doubled = -np.exp(2j * best).sum()
    if abs(doubled) < 1e-9 * len(best):
        return 0.0
    angle = 0.5 * float(np.angle(doubled))
    return np.pi / 2 if angle <= -np.pi / 2 else angle
