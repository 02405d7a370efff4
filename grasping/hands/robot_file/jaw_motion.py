"""How the jaws of a gripper move: pad faces, fingertips and the distance between the pads."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from eyehand.errors import InputError

from .pad_turn import pad_turn, wedge_start
from .posing import Drives, Posing
from .shapes import clipped, clipped_box
from .tool_frame import HandShapes, JawSides, approach_axis, jaw_sides

PAD_RELIEF = 2e-3
"""Depth of grooves, and curvature of a pad, m. What lies farther back is no part of the pad."""
PAD_BREAK = 5e-3
"""Gap along the finger that ends a pad, m."""
TIP_SHARE = 0.5
"""Share of the finger, from its tip, on which the pad is searched."""
PAD_SHARE = 0.25
"""Share of the finger, from its tip, into which every finger of a side reaches. The rest is
linkage."""
MIN_STROKE = 2e-3
"""Minimum stroke of a gripper, m."""
MIN_GAIN = 1e-3
"""Least gain of opening for which the first postures are left out, m."""
MAX_CUTS = 3
"""Maximum number of times that the end of the path is corrected."""
MAX_OVERLAP = 2e-4
"""Overlap of the closed pads that counts as touching, m."""
MAX_DRIVES = 4
"""Maximum number of joints without a common drive. More are a hand of several fingers."""


@dataclass(frozen=True, eq=False)
class JawMotion:
    """Measurements of the jaws in postures from open to closed.

    The axes are those of the tool frame, the origin is that of the palm's body.
    """

    shapes: HandShapes
    """The gripper's shapes."""
    jaws: JawSides
    """Links of both sides; without links on the second one the palm is the other jaw."""
    axes: NDArray[np.float64]
    """Columns x (closing), y and z (approach) in the palm's frame, (3, 3)."""
    path: NDArray[np.float64]
    """Postures from open to closed, (K, nq)."""
    pads: tuple[tuple[int, ...], ...]
    """Links with the pads of each side; of one side only if the palm is the other jaw."""
    faces: NDArray[np.float64]
    """x of the pads' faces, (K, 2), m."""
    tips: NDArray[np.float64]
    """z of the fingertips, (K,), m."""
    length: float
    """Length of the fingers in front of the palm, m."""

    @property
    def gaps(self) -> NDArray[np.float64]:
        """Distances between the pads, (K,), m."""
        return self.faces[:, 0] - self.faces[:, 1]

    def posed(self, posture: int) -> None:
        """Move the gripper to a posture of the path."""
        self.shapes.pose(self.path[posture])

    def of_links(self, links: Sequence[int]) -> NDArray[np.float64]:
        """Return triangles of links at the present posture, (T, 3, 3), m."""
        return self.shapes.of_links(links) @ self.axes

    def fixed(self) -> NDArray[np.float64]:
        """Return triangles of the palm, (T, 3, 3), m."""
        return self.shapes.triangles(self.shapes.fixed_geoms) @ self.axes

    def side_sign(self, side: int) -> float:
        """Return 1 for the jaw at +x and -1 for the other."""
        return 1.0 - 2.0 * side

    def pad_extent(self, side: int, posture: int) -> tuple[float, float, float]:
        """Return least y, greatest y and least z of the pads of a side, m."""
        self.posed(posture)
        if side < len(self.pads):
            parts = [self.of_links([link]) for link in self.pads[side]]
        else:
            parts = [self.fixed()]
        found = [self._pad_points(part, side, posture) for part in parts]
        points = np.concatenate([points for points in found if len(points)])
        return float(points[:, 1].min()), float(points[:, 1].max()), float(points[:, 2].min())

    def _pad_points(
        self, triangles: NDArray[np.float64], side: int, posture: int
    ) -> NDArray[np.float64]:
        """Return points (N, 3) of a finger's face, m."""
        face, tip, sign = self.faces[posture, side], self.tips[posture], self.side_sign(side)
        if side < len(self.pads):
            # Fingers of one side may differ. Each has a face of its own.
            near = clipped(triangles, 2, tip - TIP_SHARE * self.length, np.inf)[:, 0]
            face = sign * (sign * near).min() if len(near) else face
        bounds = sorted((face - sign * 1e-5, face + sign * PAD_RELIEF))
        low = np.array([bounds[0], -np.inf, tip - self.length])
        high = np.array([bounds[1], np.inf, np.inf])
        inside = clipped_box(triangles, low, high)
        pieces = inside[np.argsort(-inside[:, :, 2].max(axis=1), kind="stable")]
        kept, bottom = [np.zeros((0, 3))], np.inf
        for piece in pieces:
            if piece[:, 2].max() < bottom - PAD_BREAK and bottom < np.inf:
                break
            bottom = min(bottom, float(piece[:, 2].min()))
            kept.append(piece)
        return np.concatenate(kept)


def jaw_motion(posing: Posing, palm: int, branches: list[list[int]], tcp: str | None) -> JawMotion:
    """Find how the jaws close, and measure them on the way.

    Raises
    ------
    InputError
        If nothing closes, or the directions cannot be decided.
    """
    shapes = HandShapes(posing, palm, branches)
    drives = posing.drives
    if len(drives.joints) > MAX_DRIVES:
        names = ", ".join(posing.model.joint(j).name for j in drives.joints[:4])
        raise InputError(
            f"{len(drives.joints)} joints move without a common drive ({names}, …): this is a hand "
            "of several fingers, not a gripper with two jaws"
        )
    errors: list[InputError] = []
    found: list[tuple[float, float, JawMotion]] = []
    for first, last in _end_positions(drives):
        # Jaws that pass each other at the end confuse the sides. Half of the way is then enough.
        for share in (1.0, 0.5):
            try:
                path = posing.path(first, first + share * (last - first))
                motion = _until_touch(shapes, branches, path, posing, tcp)
            except InputError as error:
                errors.append(error)
                continue
            closed = motion.gaps[0] - max(motion.gaps[-1], 0.0)
            if motion.gaps[0] > MIN_STROKE and closed > MIN_STROKE:
                found.append((closed, -pad_turn(motion), motion))
                break
    if not found:
        # A question has an answer already, or no other error is as helpful.
        asked = [error for error in errors if str(error).startswith("--") == (tcp is None)]
        if asked or errors:
            raise (asked or errors)[0]
        raise InputError(
            "no gripper is found: no jaw closes towards another one or the palm (moved: "
            f"{', '.join(posing.model.joint(j).name for j in drives.joints)})"
        )
    best = max(one[0] for one in found)
    return max((o for o in found if o[0] > 0.5 * best), key=lambda o: (round(o[1], 2), o[0]))[2]


def _end_positions(drives: Drives) -> list[tuple[NDArray[np.float64], NDArray[np.float64]]]:
    """Return the pairs of end positions of the drives between which a gripper may close."""
    flips = map(np.array, itertools.product((False, True), repeat=len(drives.joints)))
    return [
        (np.where(flip, drives.last, drives.first), np.where(flip, drives.first, drives.last))
        for flip in flips
    ]


def _measured(
    shapes: HandShapes, branches: list[list[int]], path: NDArray[np.float64], tcp: str | None
) -> JawMotion:
    """Measure the jaws along a path that should close them."""
    jaws = jaw_sides(shapes, path, branches)
    x = jaws.closing
    z = approach_axis(shapes, path, jaws, tcp)
    axes = np.column_stack([x, np.cross(z, x), z])
    shapes.pose(path[-1])
    fingers = shapes.of_links(jaws.sides[0] + jaws.sides[1]) @ axes
    tip = float(fingers[:, :, 2].max())
    palm = shapes.triangles(shapes.fixed_geoms) @ axes
    base = float(fingers[:, :, 2].min())
    front = float(palm[:, :, 2].max()) if len(palm) and jaws.sides[1] else base
    length = tip - (front if base < front < tip else base)
    low = tip - TIP_SHARE * length
    pads = tuple(
        _pad_links(shapes, fingers, axes, (low, tip - PAD_SHARE * length), 1.0 - 2.0 * side)
        for side, fingers in enumerate(jaws.fingers)
        if fingers
    )
    motion = JawMotion(
        shapes, jaws, axes, path, pads, np.zeros((len(path), 2)), np.zeros(len(path)), length
    )
    measured_faces(motion)
    if len(pads) == 1:
        motion.faces[:, 1] = _fixed_face(motion)
    return motion


def measured_faces(motion: JawMotion) -> None:
    """Measure `faces` and `tips` of the moving jaws in all postures.

    Raises
    ------
    InputError
        If a jaw does not reach beside the other one.
    """
    for number in range(len(motion.path)):
        motion.posed(number)
        parts = [motion.of_links(links) for links in motion.pads]
        motion.tips[number] = max(float(part[:, :, 2].max()) for part in parts)
        low = motion.tips[number] - TIP_SHARE * motion.length
        for side, part in enumerate(parts):
            along = clipped(part, 2, low, np.inf)[:, 0]
            if not len(along):
                raise InputError("no gripper is found: one jaw does not reach beside the other")
            motion.faces[number, side] = along.max() if side else along.min()


def _pad_links(
    shapes: HandShapes,
    fingers: list[list[int]],
    axes: NDArray[np.float64],
    levels: tuple[float, float],
    sign: float,
) -> tuple[int, ...]:
    """Return the pad's link of each finger that reaches near the tips.

    `levels` are the z from which on the pad is searched, and the z that a finger must reach, m.
    """
    links = [_pad_link(shapes, finger, axes, levels[0], sign) for finger in fingers]
    tops = [float((shapes.of_links([link]) @ axes)[:, :, 2].max(initial=-np.inf)) for link in links]
    return tuple(
        link for link, top in zip(links, tops, strict=True) if top >= min(levels[1], max(tops))
    )


def _pad_link(
    shapes: HandShapes, links: list[int], axes: NDArray[np.float64], low: float, sign: float
) -> int:
    """Return the link of a side that is innermost near the fingertip."""
    best, inner = links[-1], np.inf
    for link in links:
        points = clipped(shapes.of_links([link]) @ axes, 2, low, np.inf)
        if len(points) and (face := float((sign * points[:, 0]).min())) < inner - 1e-6:
            best, inner = link, face
    return best


def _fixed_face(motion: JawMotion) -> float:
    """Return x of the face of the palm that opposes the one moving jaw, m."""
    motion.posed(len(motion.path) - 1)
    moving = motion.of_links(motion.pads[0])
    low = np.array([-np.inf, moving[:, :, 1].min(), motion.tips[-1] - TIP_SHARE * motion.length])
    high = np.array([float(moving[:, :, 0].mean()), moving[:, :, 1].max(), motion.tips[-1] + 0.01])
    palm = motion.fixed()
    points = clipped_box(palm, low, high).reshape(-1, 3)
    if not len(points):
        jaw = motion.shapes.links.name(motion.pads[0][0])
        unmoved = ", ".join(motion.shapes.posing.unmoved(motion.path))
        cause = (
            f"no motor, equality or mimic moves {unmoved}"
            if unmoved
            else "as with the last link of an arm whose gripper is in another file, or jaws that "
            "do not move equally far (mimic multiplier)"
        )
        raise InputError(f"no gripper is found: nothing opposes the jaw {jaw!r}, {cause}")
    return float(points[:, 0].max())


def _until_touch(
    shapes: HandShapes,
    branches: list[list[int]],
    path: NDArray[np.float64],
    posing: Posing,
    tcp: str | None,
) -> JawMotion:
    """Measure a path up to the posture in which the pads touch."""
    motion = _measured(shapes, branches, path, tcp)
    places = posing.model.jnt_qposadr[list(posing.drives.joints)]
    for _ in range(MAX_CUTS):
        gaps = motion.gaps
        # A jaw that turns by 90° begins behind the other one: its gap is first negative.
        open_at = int(np.argmax(gaps))
        if gaps[open_at] <= 0.0:
            break
        end = float(open_at + np.argmin(gaps[open_at:]))
        beyond = open_at + np.flatnonzero(gaps[open_at:] < 0.0)
        if len(beyond):
            last = int(beyond[0])
            end = last - 1 + gaps[last - 1] / (gaps[last - 1] - gaps[last])
        start = wedge_start(motion, int(np.ceil(end)))
        # On a wide arc the base of a finger swings back in front of the other one.
        widest = start + int(np.argmax(gaps[start : int(np.ceil(end)) + 1]))
        if gaps[widest] > gaps[start] + MIN_GAIN:
            start = widest
        whole = start == 0 and end >= len(gaps) - 1
        if start >= end or (whole and gaps.min() > -MAX_OVERLAP):
            break
        numbers = np.arange(len(gaps), dtype=float)
        first, last_place = (
            np.array([np.interp(share, numbers, one) for one in motion.path[:, places].T])
            for share in (start, end)
        )
        motion = _measured(shapes, branches, posing.path(first, last_place), tcp)
    return motion
