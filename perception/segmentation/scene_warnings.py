"""Warnings about a segmentation: what it could not decide, and what the image does not show."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from .connected_parts import connected_parts
from .container import Container
from .remove_steep import MIN_SIZE
from .result import SupportPlane
from .select_supports import MIN_FIRST_AREA
from .support_extent import Support
from .working_image import WorkingImage

WarningKind = Literal[
    "no_support",
    "support_doubtful",
    "below_support",
    "support_hidden",
    "support_unseen",
    "support_tilted",
    "container",
    "container_heaped",
    "nothing_found",
    "object_missing",
    "cut_by_image",
    "may_be_several",
    "may_be_background",
    "camera",
    "principal_point",
    "pose",
    "far",
    "near",
    "noise",
    "constant",
]
"""The kind of a warning.

- no_support: there is no support plane, so that every smooth solid counts as an object.
- support_doubtful: another plane has nearly the evidence of the support, or may be a small table
  high above it; `SceneWarning.plane` holds it. Or more readings continue its level outside its
  outline than lie within, so that objects beside the outline are lost.
- below_support: readings lie below the support within its outline.
- support_hidden: no part of the first support is visible. It is a plane below all readings.
- support_unseen: much of the image is in front of the supports and out of their reach. It stands on
  a surface that was not found, such as the board of a shelf seen edge-on.
- support_tilted: the support tilts by more than 3° in the world. If it is level, the rotation of
  the camera's pose is wrong.
- container: a bin, tote, box or tray is in the scene. Its floor and walls are no objects.
- container_heaped: the contents of a container hide its whole floor.
- nothing_found: there is no object, although readings stand above the support.
- object_missing: readings that may be an object belong to none. Only a side of it is visible, at a
  grazing angle, or nothing that supports it. They are obstacles, and its hidden part is not.
- cut_by_image: the border of the image cuts an object off.
- may_be_several: geometry alone does not show whether a region is one object.
- may_be_background: only a long thin sheet of an object is visible. It may be a part of a wall, a
  board or a floor.
- camera: the intrinsics are implausible, so that all positions may be wrong: the principal point
  is not inside the image, or the field of view or the ratio of the focal lengths is odd.
- principal_point: it is far from the middle of the image, as in a crop. Otherwise the intrinsics
  belong to another resolution.
- pose: the pose of the camera is implausible: the largest plane is far from horizontal with it, or
  the camera is more than 20 m from the origin. It may be inverted or in mm.
- far: nearly all readings are too far for solids; the depth may have another unit.
- near: many readings are nearer than most cameras measure; the depth may have another unit.
- noise: the readings are noise; there is no smooth surface.
- constant: all readings are equal; the image shows at most a bare plane, without noise.
"""

MIN_RUNNER_UP = 0.3
"""Minimum score of another plane, relative to that of the support, for "support_doubtful". It is at
most 0.22 on single tables."""
SAME_PLANE = 0.015
"""Maximum distance between a support and the floor of a container that are the same plane, m."""
MAX_DROP = 0.5
"""Depth of a plane below the support from which it is the floor of the room, m."""
MIN_BELOW = 0.03
"""Minimum weight of the readings below a support, relative to those on it, for "below_support". It
is at most 0.014 on tables and floors of containers."""
MIN_CONTINUED = 2.0
"""Minimum number of readings that continue the support outside its outline, per reading within, for
"support_doubtful". It is at most 1.1 where the outline is right, and 10 where a table with holes
was cut up. Around a container the table may have the level of the floor."""
MIN_UNREACHED = 0.1
"""Minimum size of a connected part in front of the supports for "support_unseen", as a share of the
pixels. It is at most 0.02 where a board was found, and 0.28 or more where none was."""
MIN_UNEXPLAINED = 0.005
"""Minimum size of a connected part above the support for "nothing_found", as a share of the
pixels."""


@dataclass(frozen=True)
class SceneWarning:
    """One warning."""

    kind: WarningKind
    """What it is about."""
    message: str
    """The warning in words."""
    label: int | None = None
    """Label of the object that it is about, or None for the whole scene."""
    plane: SupportPlane | None = None
    """The other plane of "support_doubtful", camera frame."""


def find_warnings(
    labels: NDArray[np.int32],
    ambiguous: dict[int, str],
    supports: list[Support],
    containers: tuple[Container, ...],
    above: NDArray[np.bool_],
    unreached: float = 0.0,
    sheets: tuple[int, ...] = (),
    continued: float = 0.0,
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
    containers
        The containers.
    above
        Mask of the readings above the supports, of any size.
    unreached
        Share of the pixels in front of the supports and out of their reach, 0-1.
    sheets
        Labels of the objects of which only a long thin sheet is visible.
    continued
        Readings that continue the first support outside its outline, per reading within.
    """
    warnings: list[SceneWarning] = []
    if not supports:
        message = "no support plane was found: every smooth solid counts as an object"
        warnings.append(SceneWarning("no_support", message))
    if supports:
        warnings += _support_warnings(supports[0], containers)
    if continued >= MIN_CONTINUED and not containers:
        message = "the support is doubtful: most readings on its level lie outside its outline"
        warnings.append(SceneWarning("support_doubtful", message))
    if unreached >= MIN_UNREACHED:
        message = (
            f"{100 * unreached:.0f} % of the image is in front of the support and out of its "
            "reach: the surface under it was not found, and nothing there is an object"
        )
        warnings.append(SceneWarning("support_unseen", message))
    warnings += _container_warnings(supports, containers)
    share = 0.0 if labels.any() else _largest_share(above)
    if share >= MIN_UNEXPLAINED:
        message = f"no object was found, although {100 * share:.1f} % of the pixels may show one"
        warnings.append(SceneWarning("nothing_found", message))
    border = np.concatenate([labels[0], labels[-1], labels[:, 0], labels[:, -1]])
    for label in np.unique(border[border > 0]).tolist():
        message = f"object {label} is cut off by the border of the image"
        warnings.append(SceneWarning("cut_by_image", message, label))
    for label, reason in sorted(ambiguous.items()):
        message = f"object {label} may be more or less than one object: {reason}"
        warnings.append(SceneWarning("may_be_several", message, label))
    for label in sheets:
        message = f"object {label} is a long thin sheet: it may be a part of a wall or a board"
        warnings.append(SceneWarning("may_be_background", message, label))
    return tuple(warnings)


def lost_warnings(lost: NDArray[np.bool_], image: WorkingImage, stride: int) -> list[SceneWarning]:
    """Return a warning for each large part of the readings that may be an object and are none.

    `lost` (H, W) marks these readings in the working image, and `stride` is its step, px.
    """
    warnings: list[SceneWarning] = []
    if np.count_nonzero(lost) < image.area(MIN_SIZE):
        return warnings
    parts = connected_parts(lost.astype(np.uint8), diagonal=True)
    for part in np.flatnonzero(parts.sizes[1:] >= image.area(MIN_SIZE)) + 1:
        top, left, bottom, right = parts.boxes[part]
        row, column = stride * (top + bottom) // 2, stride * (left + right) // 2
        message = (
            f"{stride**2 * parts.sizes[part]} readings around column {column}, row {row} may be an "
            "object: only a steep side is visible, or nothing below it. They count as obstacles"
        )
        warnings.append(SceneWarning("object_missing", message))
    return warnings


def _support_warnings(support: Support, containers: tuple[Container, ...]) -> list[SceneWarning]:
    warnings: list[SceneWarning] = []
    # Walls around the support prove it. The rival is then a large object in the container.
    enclosed = any(
        one.floor_seen and abs(one.floor.offset - support.plane.offset) < SAME_PLANE
        for one in containers
    )
    other = support.runner_up
    # A plane that is too small for a support was named because it lies high above it.
    rival = other is not None and (
        other.area < MIN_FIRST_AREA or other.score >= MIN_RUNNER_UP * support.score
    )
    if other is not None and rival and not enclosed:
        rise = support.plane.offset - other.plane.offset
        if rise > -MAX_DROP:
            share = f"{100 * other.score / support.score:.0f} %"
            where = f"{100 * abs(rise):.1f} cm {'above' if rise > 0 else 'below'} it"
            message = f"the support is doubtful: a plane {where} has {share} of its score"
            warnings.append(SceneWarning("support_doubtful", message, plane=other.plane))
    if support.share_below >= MIN_BELOW:
        share = f"{100 * support.share_below:.0f} %"
        message = f"readings lie below the support within its outline: {share} of those on it"
        warnings.append(SceneWarning("below_support", message))
    return warnings


def _container_warnings(
    supports: list[Support], containers: tuple[Container, ...]
) -> list[SceneWarning]:
    warnings: list[SceneWarning] = []
    for container in containers:
        rim = f"{100 * container.rim:.1f} cm"
        message = f"a container with a rim of {rim} is in the scene: its walls are no objects"
        warnings.append(SceneWarning("container", message))
        if container.floor_seen:
            continue
        message = "the contents of the container hide its floor, which may lie lower than assumed"
        warnings.append(SceneWarning("container_heaped", message))
        if supports and supports[0].plane is container.floor:
            message = "the support is hidden: it is assumed below all readings in the container"
            warnings.append(SceneWarning("support_hidden", message))
    return warnings


def _largest_share(mask: NDArray[np.bool_]) -> float:
    """Return the size of the largest connected part of a mask, as a share of its pixels."""
    return float(connected_parts(mask.astype(np.uint8)).sizes[1:].max(initial=0)) / mask.size
