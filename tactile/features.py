"""Contact features of a tactile image."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from scipy.sparse import csr_matrix
from scipy.sparse.csgraph import connected_components

from eyehand.errors import InputError

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from .image import TactileImage


@dataclass(frozen=True)
class ContactFeatures:
    """What one contact feels like; false in a condition when nothing touches."""

    force: float
    """Sum of the region's tactel forces f, N (eq. 11)."""
    centre: NDArray[np.float64]
    """Centre of pressure in the sensor's frame, (3,), m (eq. 11)."""
    pressure: float
    """Mean pressure over the contact region, Pa (eq. 12 with the region's area)."""
    area: float
    """Area of the contact region, m²."""
    orientation: float
    """Direction of the region's long axis in the sensor's xy-plane, rad, in (-π/2, π/2]."""
    confidence: float
    """(λ1-λ2)/(λ1+λ2) of the region's second moments: 0 round, 1 a line."""

    def __bool__(self) -> bool:
        return self.force > 0.0


def contact_features(image: TactileImage, threshold: float) -> ContactFeatures:
    """Find the largest connected contact region and describe it.

    Parameters
    ----------
    image
        Calibrated tactile image.
    threshold
        Pressure above which a tactel counts as touched, Pa, >= 0, just above the noise.

    Returns
    -------
    ContactFeatures
        Of the largest connected region, as the chapter has it; all zero where nothing touches.

    Raises
    ------
    InputError
        If the threshold is negative or not finite.
    """
    if not 0.0 <= threshold < float("inf"):
        raise InputError(f"threshold must be finite and >= 0 Pa, got {threshold}")
    touched = np.flatnonzero(image.pressures > threshold)
    if touched.size == 0:
        return ContactFeatures(0.0, np.zeros(3), 0.0, 0.0, 0.0, 0.0)
    links = csr_matrix(image.array.neighbours[np.ix_(touched, touched)])
    _, regions = connected_components(links, directed=False)
    region = touched[regions == int(np.argmax(np.bincount(regions)))]
    forces = image.pressures[region] * image.array.area
    force = float(forces.sum())
    positions = image.array.positions[region]
    centre = forces @ positions / force
    orientation, confidence = _long_axis(positions[:, :2] - centre[:2], forces / force)
    area = image.array.area * region.size
    return ContactFeatures(force, centre, force / area, area, orientation, confidence)


def _long_axis(offsets: NDArray[np.float64], weights: NDArray[np.float64]) -> tuple[float, float]:
    """Angle and confidence from second moments; the angle is halved from the doubled angle."""
    x, y = offsets.T
    xx, yy, xy = weights @ (x * x), weights @ (y * y), weights @ (x * y)
    spread = float(xx + yy)
    split = float(np.hypot(xx - yy, 2.0 * xy))
    if spread <= 0.0:
        return 0.0, 0.0
    angle = 0.5 * float(np.arctan2(2.0 * xy, xx - yy))
    return (np.pi / 2 if angle <= -np.pi / 2 else angle), split / spread
