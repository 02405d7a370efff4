"""The result of a segmentation: labels, support planes, ambiguous objects, times."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from .connected_parts import measure_parts

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray
    from scipy.spatial.transform import RigidTransform

    from .container import Container
    from .scene_warnings import SceneWarning
    from .unknown_regions import UnknownRegion


@dataclass(frozen=True)
class SupportPlane:
    """A plane that objects stand on: ``normal · x + offset = 0``."""

    normal: NDArray[np.float64]
    """Unit normal, (3,), towards the objects."""
    offset: float
    """Offset, m: the height of the frame's origin above the plane."""
    tolerance: float = 0.0
    """Standard deviation of the plane's own readings about it, m."""

    def height(self, points: ArrayLike) -> NDArray[np.float64]:
        """Return the signed heights (…,) of points (…, 3) above the plane, m."""
        return np.asarray(points) @ self.normal + self.offset

    def moved(self, T_a_b: RigidTransform) -> SupportPlane:
        """Return the plane in frame a, for a plane in frame b."""
        normal = T_a_b.rotation.apply(self.normal)
        offset = self.offset - float(normal @ T_a_b.translation)
        return SupportPlane(normal, offset, self.tolerance)


@dataclass(frozen=True)
class Segmentation:
    """The objects of one frame."""

    labels: NDArray[np.int32]
    """(H, W) int32: 0 = not an object, 1..n = objects, largest first."""
    support: SupportPlane | None
    """The support plane in the camera frame, or None when no plane was found."""
    noise: float
    """Noise σ of disparity, measured on this frame, 1/m."""
    timings: dict[str, float]
    """Time of each stage, s, in the order of the stages."""
    ambiguous: dict[int, str] = field(default_factory=dict)
    """Label → reason why the region may be more, or less, than one object. Objects without such a
    reason have no entry."""
    other_supports: tuple[SupportPlane, ...] = ()
    """Further support planes in the camera frame, such as the boards of a shelf."""
    containers: tuple[Container, ...] = ()
    """Bins, totes, boxes and trays in the camera frame, largest first."""
    warnings: tuple[SceneWarning, ...] = ()
    """What the segmentation could not decide, or the image does not show."""
    unknown: tuple[UnknownRegion, ...] = ()
    """Regions of the support without readings, camera frame, largest first. Something transparent,
    shiny or dark may stand there."""

    @property
    def count(self) -> int:
        """Number of objects."""
        return int(self.labels.max(initial=0))

    def boxes(self) -> dict[int, tuple[slice, slice]]:
        """Return the rows and columns of each object's bounding box, by label."""
        sizes, boxes = measure_parts(self.labels, self.count + 1)
        return {
            label: (slice(top, bottom), slice(left, right))
            for label, (top, left, bottom, right) in enumerate(boxes.tolist())
            if label and sizes[label]
        }

    def mask(self, label: int) -> NDArray[np.bool_]:
        """Return the mask of one object, (H, W) bool."""
        return self.labels == label
