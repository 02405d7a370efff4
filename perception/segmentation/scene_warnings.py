"""Warnings about a segmentation: what it could not decide, and what the image does not show."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from .support_extent import Support

WarningKind = Literal[
    "no_support",
    "container",
    "nothing_found",
    "cut_by_image",
    "may_be_several",
    "camera",
    "noise",
    "constant",
]
"""The kind of a warning.

- no_support: there is no support plane, so that every smooth solid counts as an object.
- container: the support is the floor of a bin, tote, box or tray. Its walls are no objects.
- nothing_found: there is no object, although readings stand above the support.
- cut_by_image: the border of the image cuts an object off.
- may_be_several: geometry alone does not show whether a region is one object.
- camera: the intrinsics are implausible, so that all positions may be wrong: the principal point
  lies outside the image, or the field of view or the ratio of the focal lengths is odd.
- noise: the readings are noise; there is no smooth surface.
- constant: all readings are equal; the image shows no scene.
"""

MIN_UNEXPLAINED = 0.02
"""Minimum share of the readings that stand above the support for "nothing_found"."""


@dataclass(frozen=True)
class SceneWarning:
    """One warning."""

    kind: WarningKind
    """What it is about."""
    message: str
    """The warning in words."""
    label: int | None = None
    """Label of the object that it is about, or None for the whole scene."""


def find_warnings(
    labels: NDArray[np.int32],
    ambiguous: dict[int, str],
    supports: list[Support],
    above: NDArray[np.bool_],
    *,
    enclosed: bool,
) -> tuple[SceneWarning, ...]:
    """Return the warnings about a segmentation, those about the scene first.

    Parameters
    ----------
    labels
        Objects 1..n (H, W).
    ambiguous
        Label → reason why the region may be more, or less, than one object.
    supports
        The supports, best first.
    above
        Mask of the readings above the supports, of any size.
    enclosed
        Whether the first support is the floor of a container.
    """
    warnings: list[SceneWarning] = []
    if not supports:
        message = "no support plane was found: every smooth solid counts as an object"
        warnings.append(SceneWarning("no_support", message))
    if enclosed:
        message = "the support is the floor of a container: its walls are no objects"
        warnings.append(SceneWarning("container", message))
    share = float(above.mean())
    if not labels.any() and share >= MIN_UNEXPLAINED:
        message = f"no object was found, although {100 * share:.0f} % of the pixels may show one"
        warnings.append(SceneWarning("nothing_found", message))
    border = np.concatenate([labels[0], labels[-1], labels[:, 0], labels[:, -1]])
    for label in np.unique(border[border > 0]).tolist():
        message = f"object {label} is cut off by the border of the image"
        warnings.append(SceneWarning("cut_by_image", message, label))
    for label, reason in sorted(ambiguous.items()):
        message = f"object {label} may be more or less than one object: {reason}"
        warnings.append(SceneWarning("may_be_several", message, label))
    return tuple(warnings)
