"""Contact features of a tactile image, eqs. (11) and (12)."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from eyehand.errors import InputError

from .feature_kernels import (
    AREA,
    BORDER_SHARE,
    CENTRE,
    CONFIDENCE,
    DEAD_COUNT,
    FORCE,
    HAS_CONTACT,
    NORMAL,
    ORIENTATION,
    SATURATED_COUNT,
    TACTEL_COUNT,
    TRUSTED,
    VALUE_COUNT,
    ContactRule,
    compute_features,
)
from .hough import hough_axis
from .image import TactileImage
from .region import find_region

MAX_BORDER_SHARE = 0.05
"""Maximum share of the force on border tactels of a contact that the border does not cut off. A
line that leaves the pad has 0.1, and its centre along the line is then unknown. A 2 mm probe has
0.05 at 9 mm from the edge of a 5 mm grid. Its measured centre is 0.1 mm too far inside only from
0.35 on, 6 mm from the edge."""


@dataclass(frozen=True)
class FeatureOptions:
    """Detection and description of a contact.

    Raises
    ------
    InputError
        If a value is out of its range.
    """

    sigmas: float = 4.0
    """Threshold of a touch above the reading at rest, in standard deviations of each tactel's
    noise, > 0. A lower value detects lighter touches and more false ones."""
    min_tactels: int = 2
    """Minimum number of tactels of a contact, >= 1. Noise rarely raises two neighbours at once, so
    2 permits a low threshold. 1 is for arrays whose tactels are far apart."""
    rim_band: float = 5.0
    """Range above the threshold, in multiples of it, >= 0. Over this range the counted part of a
    tactel's area grows from 0 to 1. With 0, as in eq. (12), f/|R| jumps whenever noise raises a
    tactel at the imprint's rim above the threshold. A wider range is less noisy and excludes more
    of a soft rim: on a pen's end the standard deviation is 5.3, 1.0, 0.4 and 0.3 % at 0, 2, 5 and
    10, and the force for the same pressure is 100, 92, 90 and 69 %."""
    hysteresis: float = 0.2
    """A region may be selected if it has at least (1 - hysteresis) times the tactels of the largest
    one, 0..1. Of these regions, the one nearest to the last contact is selected. 0 always selects
    the largest region, even if it is elsewhere."""
    orientation: Literal["moments", "hough"] = "moments"
    """Method for the long axis. Second moments are more precise and faster. Haschke's
    chapter uses the Hough transform, which needs a regular grid."""

    def __post_init__(self) -> None:
        if not 0 < self.sigmas < np.inf:
            raise InputError(f"sigmas must be finite and > 0, got {self.sigmas}")
        if self.min_tactels < 1:
            raise InputError(f"min_tactels must be >= 1, got {self.min_tactels}")
        if not 0 <= self.rim_band < np.inf:
            raise InputError(f"rim_band must be finite and >= 0, got {self.rim_band}")
        if not 0 <= self.hysteresis <= 1:
            raise InputError(f"hysteresis must be in 0..1, got {self.hysteresis}")
        if self.orientation not in ("moments", "hough"):
            raise InputError(f"orientation must be 'moments' or 'hough', got {self.orientation!r}")


@dataclass(frozen=True)
class ContactFeatures:
    """The features of one contact. ``bool(features)`` is false if there is no contact."""

    force: float
    """Sum of the tactel forces in the contact region, N, eq. (11)."""
    centre: NDArray[np.float64]
    """Centre of pressure in the sensor's frame, (3,), m, eq. (11). On a curved array it lies under
    the surface."""
    pressure: float
    """Mean pressure over the contact region, Pa, eq. (12) with the region's area."""
    area: float
    """Area of the contact region, m². Its faintest tactels count in part, see
    `FeatureOptions.rim_band`."""
    orientation: float
    """Direction of the region's long axis in the sensor's xy-plane, rad, in (-π/2, π/2]. On a
    curved array it is in the plane of `normal`, whose axes are those of `image.tangents`."""
    confidence: float
    """(λ1-λ2)/(λ1+λ2) of the region's second moments: 0 is round, 1 is a line."""
    normal: NDArray[np.float64] = field(default_factory=lambda: np.array([0.0, 0.0, 1.0]))
    """Outward unit normal of the contact, (3,): mean of the tactels' normals, weighted by force."""
    tactels: int = 0
    """Number of tactels of the region, |R|."""
    border_share: float = 0.0
    """Force on tactels at the array's border divided by the whole force, 0..1. The contact may
    extend beyond the border. Its centre of pressure is then too far inside."""
    saturated: int = 0
    """Number of saturated tactels in the region. Force and pressure are then too low."""
    interpolated: int = 0
    """Number of dead tactels in the region. Their pressures are means of their neighbours."""

    def __bool__(self) -> bool:
        return self.force > 0.0

    @property
    def at_border(self) -> bool:
        """Whether the array's border cuts off so much that the centre of pressure is biased."""
        return self.border_share > MAX_BORDER_SHARE


def contact_features(
    image: TactileImage,
    threshold: float | NDArray[np.float64],
    *,
    previous: ContactFeatures | None = None,
    options: FeatureOptions | None = None,
) -> ContactFeatures:
    """Compute the features of the largest contact region of one image, eqs. (11) and (12).

    For the images of a servo, `FeatureReader` is faster.

    Parameters
    ----------
    image
        Calibrated tactile image.
    threshold
        Pressure above which a tactel is touched, Pa, >= 0: one value, or one per tactel (N,). It
        should be just above the noise.
    previous
        Features of the last cycle. Among regions of similar size, the one nearest to it is used.
    options
        `sigmas` has no effect here. With None, a single tactel is a contact.

    Returns
    -------
    ContactFeatures
        The features. Without a contact all values are 0, except the normal (0, 0, 1).

    Raises
    ------
    InputError
        If a threshold is negative or not finite, or the Hough transform is requested for an array
        without a grid.
    """
    options = options or FeatureOptions(min_tactels=1)
    array, count = image.array, len(image.pressures)
    centre = previous.centre if previous else np.full(3, np.nan)
    members, values = np.empty(count, np.int32), np.empty(VALUE_COUNT)
    buffers = (
        np.ascontiguousarray(image.pressures, dtype=np.float64),
        np.full(count, TRUSTED, np.uint8),
        members,
        values,
        np.ascontiguousarray(centre),
    )
    size = compute_features(
        _thresholds(threshold, count), array.links, array.geometry, kernel_rule(options), buffers
    )
    features = unpack(values)
    if features and options.orientation == "hough":
        features = with_hough(features, image, members[:size])
    return features


def contact_region(
    image: TactileImage, threshold: float | NDArray[np.float64]
) -> NDArray[np.bool_]:
    """Find the largest connected region of touched tactels.

    Parameters
    ----------
    image
        Calibrated tactile image.
    threshold
        Pressure above which a tactel is touched, Pa, >= 0: one value, or one per tactel (N,).

    Returns
    -------
    Mask of the region's tactels, (N,).

    Raises
    ------
    InputError
        If a threshold is negative or not finite.
    """
    array, count = image.array, len(image.pressures)
    members = np.empty(count, np.int32)
    size = find_region(
        np.ascontiguousarray(image.pressures, dtype=np.float64),
        _thresholds(threshold, count),
        array.links,
        array.geometry,
        np.full(3, np.nan),
        0.0,
        members,
    )
    return _mask(members[:size], count)


def kernel_rule(options: FeatureOptions) -> NDArray[np.float64]:
    """Return the values of `feature_kernels.ContactRule`, (3,)."""
    rule = ContactRule(options.hysteresis, options.min_tactels, options.rim_band)
    return np.array(rule, np.float64)


def unpack(values: NDArray[np.float64]) -> ContactFeatures:
    """Convert the values of `feature_kernels.compute_features` to features."""
    v = values.tolist()
    if v[HAS_CONTACT] == 0.0:
        return ContactFeatures(0.0, np.zeros(3), 0.0, 0.0, 0.0, 0.0)
    return ContactFeatures(
        v[FORCE],
        values[CENTRE : CENTRE + 3].copy(),
        v[FORCE] / v[AREA],
        v[AREA],
        v[ORIENTATION],
        v[CONFIDENCE],
        values[NORMAL : NORMAL + 3].copy(),
        int(v[TACTEL_COUNT]),
        v[BORDER_SHARE],
        int(v[SATURATED_COUNT]),
        int(v[DEAD_COUNT]),
    )


def with_hough(
    features: ContactFeatures, image: TactileImage, members: NDArray[np.int32]
) -> ContactFeatures:
    """Return the features with the orientation by the Hough transform of the region's tactels."""
    region = _mask(members, len(image.pressures))
    return replace(features, orientation=hough_axis(image, region))


def _mask(members: NDArray[np.int32], count: int) -> NDArray[np.bool_]:
    mask = np.zeros(count, np.bool_)
    mask[members] = True
    return mask


def _thresholds(threshold: float | NDArray[np.float64], count: int) -> NDArray[np.float64]:
    """Check the thresholds and return one per tactel, (N,)."""
    thresholds = np.asarray(threshold, dtype=np.float64)
    if not (np.all(thresholds >= 0.0) and np.all(np.isfinite(thresholds))):
        raise InputError(f"threshold must be finite and >= 0 Pa, got {threshold}")
    if thresholds.shape not in ((), (count,)):
        raise InputError(f"threshold must be one number or {count}, got {thresholds.shape}")
    return np.full(count, thresholds) if thresholds.ndim == 0 else thresholds
