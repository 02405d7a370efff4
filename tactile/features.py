"""Contact features of a tactile image."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Literal

import numpy as np

from eyehand.errors import InputError

from .feature_kernels import TRUSTED, VALUES, describe, pack_geometry
from .hough import HoughOptions, hough_axis
from .region import pack_links

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from .image import TactileImage

BORDER_SHARE = 0.05
"""Share of force on border tactels from which a contact counts as cut off. A line that leaves the
pad, whose centre along it is then unknown, has 0.1. A 2 mm probe has it 9 mm from the edge of a
5 mm grid, and is placed 0.1 mm too far inside only from 0.35 on, 6 mm from the edge."""


@dataclass(frozen=True)
class FeatureOptions:
    """How a contact is found and described.

    Raises
    ------
    InputError
        If a value is out of its range.
    """

    sigmas: float = 4.0
    """Threshold over the reading at rest, times each tactel's noise, > 0: lower feels lighter
    touches and the rim of imprints, and takes more noise for touch."""
    min_tactels: int = 2
    """Tactels that make a contact, >= 1: noise seldom lifts two neighbours at once, so 2 lets the
    threshold be low; 1 is for arrays whose tactels are far apart."""
    rim: float = 5.0
    """Band above the threshold, times it, over which a tactel comes to count fully in the area,
    >= 0. 0 counts it at once, as eq. 12 does: then f/|R| jumps whenever noise lifts a tactel at the
    imprint's rim over the threshold. Wider is calmer, and leaves out more of a soft rim: on a pen's
    end the deviation is 5.3, 1.0, 0.4 and 0.3 % at 0, 2, 5 and 10, and the force that makes the
    same pressure 100, 92, 90 and 69 %."""
    hysteresis: float = 0.2
    """Share of tactels by which another region must be larger before it is taken instead of the
    nearest to the contact before, 0..1: 0 follows the largest one at once, however it jumps."""
    orientation: Literal["moments", "hough"] = "moments"
    """How the long axis is found: by second moments, better and faster, or by the paper's Hough
    transform, for arrays with an even grid."""
    hough: HoughOptions = field(default_factory=HoughOptions)
    """Settings of the Hough transform."""

    def __post_init__(self) -> None:
        if not 0 < self.sigmas < np.inf:
            raise InputError(f"sigmas must be finite and > 0, got {self.sigmas}")
        if self.min_tactels < 1:
            raise InputError(f"min_tactels must be >= 1 tactel, got {self.min_tactels}")
        if not 0 <= self.rim < np.inf:
            raise InputError(f"rim must be finite and >= 0, got {self.rim}")
        if not 0 <= self.hysteresis <= 1:
            raise InputError(f"hysteresis must be in 0..1, got {self.hysteresis}")
        if self.orientation not in ("moments", "hough"):
            raise InputError(f"orientation must be 'moments' or 'hough', got {self.orientation!r}")


@dataclass(frozen=True)
class ContactFeatures:
    """What one contact feels like; false in a condition when nothing touches."""

    force: float
    """Sum of the region's tactel forces f, N (eq. 11)."""
    centre: NDArray[np.float64]
    """Centre of pressure in the sensor's frame, (3,), m (eq. 11); under a curved surface."""
    pressure: float
    """Mean pressure over the contact region, Pa (eq. 12 with the region's area)."""
    area: float
    """Area of the contact region, m², its faintest tactels in part: see `FeatureOptions.rim`."""
    orientation: float
    """Direction of the region's long axis in the sensor's xy-plane, rad, in (-π/2, π/2]; on a
    curved array in the plane of `normal`, whose axes are those of `image.tangents`."""
    confidence: float
    """(λ1-λ2)/(λ1+λ2) of the region's second moments: 0 round, 1 a line."""
    normal: NDArray[np.float64] = field(default_factory=lambda: np.array([0.0, 0.0, 1.0]))
    """Outward unit normal of the contact, (3,): mean of the tactels', weighted by force."""
    tactels: int = 0
    """How many tactels the region has, |R|."""
    border_share: float = 0.0
    """Share of the force on tactels at the array's border, 0..1: beyond it, contact is not felt,
    so the centre of pressure is too far inside."""
    saturated: int = 0
    """Tactels of the region that feel more than they can tell: force and pressure are too low."""
    interpolated: int = 0
    """Tactels of the region that are dead: their pressure is their neighbours'."""

    def __bool__(self) -> bool:
        return self.force > 0.0

    @property
    def at_border(self) -> bool:
        """Whether the contact reaches over the array's border so far that its centre is biased."""
        return self.border_share > BORDER_SHARE


def contact_features(
    image: TactileImage,
    threshold: float | NDArray[np.float64],
    *,
    previous: ContactFeatures | None = None,
    options: FeatureOptions | None = None,
) -> ContactFeatures:
    """Find the largest connected contact region and describe it.

    For one image; a servo that reads many takes a `FeatureReader`.

    Parameters
    ----------
    image
        Calibrated tactile image.
    threshold
        Pressure above which a tactel counts as touched, Pa, >= 0, just above the noise: one, or
        one per tactel (N,).
    previous
        Features of the contact a moment before: of regions of similar size, the one nearest to
        it is described.
    options
        Of these, `sigmas` is of no concern here; left out, a single tactel is a contact.

    Returns
    -------
    ContactFeatures
        Of the largest connected region, as the chapter has it; all zero where nothing touches.

    Raises
    ------
    InputError
        If a threshold is negative or not finite, or Hough is asked of an array without a grid.
    """
    options = options or FeatureOptions(min_tactels=1)
    array, count = image.array, len(image.pressures)
    thresholds = np.asarray(threshold, dtype=np.float64)
    if not (np.all(thresholds >= 0.0) and np.all(np.isfinite(thresholds))):
        raise InputError(f"threshold must be finite and >= 0 Pa, got {threshold}")
    if thresholds.shape not in ((), (count,)):
        raise InputError(f"threshold must be one number or {count}, got {thresholds.shape}")
    centre = previous.centre if previous else np.full(3, np.nan)
    states = np.full(count, TRUSTED, np.uint8)
    members, values = np.empty(count, np.int32), np.empty(VALUES)
    size = describe(
        np.ascontiguousarray(image.pressures, dtype=np.float64),
        states,
        np.full(count, thresholds) if thresholds.ndim == 0 else thresholds,
        pack_links(array),
        pack_geometry(array),
        np.ascontiguousarray(centre),
        options.hysteresis,
        options.min_tactels,
        options.rim,
        members,
        values,
    )
    found = unpack(values)
    if found and options.orientation == "hough":
        found = with_hough(found, image, members[:size], options.hough)
    return found


def unpack(values: NDArray[np.float64]) -> ContactFeatures:
    """Give the numbers of `feature_kernels.describe` their names."""
    v = values.tolist()
    if v[14] == 0.0:
        return ContactFeatures(0.0, np.zeros(3), 0.0, 0.0, 0.0, 0.0)
    return ContactFeatures(
        v[0],
        values[1:4].copy(),
        v[0] / v[4],
        v[4],
        v[5],
        v[6],
        values[7:10].copy(),
        int(v[10]),
        v[11],
        int(v[12]),
        int(v[13]),
    )


def with_hough(
    found: ContactFeatures,
    image: TactileImage,
    region: NDArray[np.int32],
    options: HoughOptions,
) -> ContactFeatures:
    """Give the features with the orientation by the Hough transform of their region."""
    mask = np.zeros(len(image.pressures), np.bool_)
    mask[region] = True
    return replace(found, orientation=hough_axis(image, mask, options))
