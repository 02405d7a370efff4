"""What a segmentation says: one label per object, the support plane, and the time it took."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np
from scipy import ndimage

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray
    from scipy.spatial.transform import RigidTransform


@dataclass(frozen=True)
class SupportPlane:
    """The plane that carries the objects: ``normal · x + offset = 0``."""

    normal: NDArray[np.float64]
    """Unit normal, (3,), towards the side on which objects stand."""
    offset: float
    """Offset, m."""
    tolerance: float = 0.0
    """Spread of the plane's own readings about it, one σ, m."""

    def height(self, points: ArrayLike) -> NDArray[np.float64]:
        """Signed height of points (…, 3) above the plane, (…,), m."""
        return np.asarray(points) @ self.normal + self.offset

    def moved(self, T_a_b: RigidTransform) -> SupportPlane:
        """Give the plane in frame a, from frame b."""
        normal = T_a_b.rotation.apply(self.normal)
        offset = self.offset - float(normal @ T_a_b.translation)
        return SupportPlane(normal, offset, self.tolerance)


@dataclass(frozen=True)
class Segmentation:
    """Objects of one frame."""

    labels: NDArray[np.int32]
    """(H, W) int32: 0 = not an object, 1..n = objects, largest first."""
    support: SupportPlane | None
    """Support plane in the camera frame; None when no plane was found."""
    noise: float
    """Disparity noise σ measured on this frame, 1/m."""
    timings: dict[str, float]
    """Seconds per stage, in the order the data flows."""
    ambiguous: dict[int, str] = field(default_factory=dict)
    """Label → why geometry cannot tell whether it is one object: no entry where it can."""
    other_supports: tuple[SupportPlane, ...] = ()
    """Further planes that carry things, as a shelf or the floor beside a table."""

    @property
    def count(self) -> int:
        """Number of objects."""
        return int(self.labels.max(initial=0))

    def boxes(self) -> dict[int, tuple[slice, slice]]:
        """Rows and columns that hold each object, by label."""
        found = ndimage.find_objects(self.labels)
        return {number: box for number, box in enumerate(found, start=1) if box is not None}

    def mask(self, label: int) -> NDArray[np.bool_]:
        """Pixels of one object, (H, W) bool."""
        return self.labels == label
