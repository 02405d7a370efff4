"""How the pads of jaws turn, and their middle moves, while they close."""

from __future__ import annotations

import itertools
from typing import TYPE_CHECKING

import numpy as np
from scipy.spatial.transform import Rotation

from .read_model import load_mujoco
from .shapes import clipped, clipped_box

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from .jaw_motion import JawMotion

MAX_WEDGE = np.deg2rad(45.0)
"""Maximum angle between pads that turn. Objects slip out of a wider one: each pad holds up to the
angle of friction, 22° at a coefficient of 0.4."""
MIN_TURN = np.deg2rad(1.0)
"""Turn below which pads count as parallel in all postures."""
REPORTED_TURN, REPORTED_LENGTH = np.deg2rad(3.0), 3e-3
"""Turn of the pads, distance beyond their gap and shift of their middle that are reported, rad and
m. The usual error of calibration is as large."""
PROFILE = (0.4, 0.05)
"""Part of the finger in which the face of its pad is measured, as shares from the tip."""
MAX_UNEVEN = 2e-3
"""Maximum distance of a flat face from a plane, m."""


def pad_turn(motion: JawMotion) -> float:
    """Return by how much the pads turn while they close, rad."""
    first, last = _pad_frames(motion, (0, len(motion.path) - 1))
    return _angle(first, last)


def motion_remarks(motion: JawMotion, shift: NDArray[np.float64]) -> list[str]:
    """Return what a user should know about the motion of the pads, one line each.

    ``shift`` is that of :func:`middle_shift`.
    """
    remarks = []
    first, last = _pad_frames(motion, (0, len(motion.path) - 1))
    turn = _angle(first[:1], last[:1])
    if turn > REPORTED_TURN:
        remarks.append(
            f"the pads turn by {np.rad2deg(turn):.0f}° while they close; the opening is that of "
            "the narrowest place"
        )
    apart, gap = _closed_distance(motion), max(float(motion.gaps[-1]), 0.0)
    if apart > gap + REPORTED_LENGTH:
        remarks.append(
            f"the closed pads are {1e3 * apart:.0f} mm apart, but {1e3 * gap:.0f} mm along x: "
            "they may pass beside each other, or the file is wrong; look at the picture"
        )
    tips = [motion.of_links(pad)[:, :, 2].max() for pad in motion.pads]
    if (unequal := float(np.ptp(tips))) > REPORTED_LENGTH:
        remarks.append(
            f"one jaw is {1e3 * unequal:.0f} mm longer than the other: nothing opposes this end, "
            "and grasps hold there; use jaws of equal length"
        )
    if np.hypot(*shift) > REPORTED_LENGTH:
        remarks.append(
            f"the middle between the pads moves by {1e3 * shift[0]:.0f} mm along x and "
            f"{1e3 * shift[1]:.0f} mm along y while they open"
        )
    return remarks


def _closed_distance(motion: JawMotion) -> float:
    """Return the least distance between the hulls of both jaws' pads in the closed posture, m.

    It is at most the last of `gaps`, unless the pads pass beside each other.
    """
    mujoco = load_mujoco()
    posing = motion.shapes.posing
    motion.posed(len(motion.path) - 1)
    sides = [[g for link in pad for g in motion.shapes.link_geoms[link]] for pad in motion.pads]
    sides += [motion.shapes.fixed_geoms] if len(sides) == 1 else []
    return min(
        mujoco.mj_geomDistance(posing.model, posing.data, one, other, 1.0, None)
        for one, other in itertools.product(*sides)
    )


def middle_shift(motion: JawMotion) -> NDArray[np.float64]:
    """Return x and y of the middle between the open pads, seen from the closed ones, (2,), m.

    It is the line through the closed posture that is nearest to all others.
    """
    openings = motion.gaps - motion.gaps[-1]
    ends = [motion.pad_extent(0, 0), motion.pad_extent(1, 0)]
    closed = [motion.pad_extent(side, len(motion.path) - 1) for side in (0, 1)]
    y = 0.25 * sum(e[0] + e[1] - c[0] - c[1] for e, c in zip(ends, closed, strict=True))
    middles = motion.faces.mean(axis=1) - motion.faces[-1].mean()
    x = openings[0] * float(openings @ middles) / float(openings @ openings)
    return np.array([x, y], dtype=np.float64)


def wedge_start(motion: JawMotion, closed: int) -> int:
    """Return the first posture in which turning pads enclose an angle that can hold something.

    Pads that touch first at their tips enclose a negative angle then. Where their faces are not
    flat, they count as parallel in the posture ``closed``.
    """
    frames = _pad_frames(motion, range(len(motion.path)))
    if _angle(frames[0], frames[closed]) < MIN_TURN:
        return 0
    at_closed = sum(_lean(motion, side, closed) for side in (0, 1))
    start = closed
    while start > 0:
        opened = sum(
            motion.side_sign(side) * _turn_about_y(motion, one, other)
            for side, (one, other) in enumerate(zip(frames[closed], frames[start - 1], strict=True))
        )
        if at_closed + opened > MAX_WEDGE:
            break
        start -= 1
    return start


def _turn_about_y(
    motion: JawMotion, before: NDArray[np.float64], after: NDArray[np.float64]
) -> float:
    """Return by how much a pad turns about y of the tool frame, rad."""
    turn, _ = motion.shapes.base_pose()
    axes = turn @ motion.axes
    return float(Rotation.from_matrix(axes.T @ after @ before.T @ axes).as_rotvec()[1])


def _lean(motion: JawMotion, side: int, posture: int) -> float:
    """Return by how much the face of a pad leans outwards, rad; 0 where it is not flat."""
    motion.posed(posture)
    if side < len(motion.pads):
        triangles = motion.of_links(motion.pads[side])
    else:
        points = motion.of_links(motion.pads[0]).reshape(-1, 3)
        low = np.array([-np.inf, points[:, 1].min(), -np.inf])
        high = np.array([points[:, 0].mean(), points[:, 1].max(), np.inf])
        triangles = clipped_box(motion.fixed(), low, high)
    sign, tip = motion.side_sign(side), float(motion.tips[posture])
    rows = np.linspace(tip - PROFILE[0] * motion.length, tip - PROFILE[1] * motion.length, 9)
    heights, faces = [], []
    for bottom, top in itertools.pairwise(rows):
        along = clipped(triangles, 2, float(bottom), float(top))[:, 0]
        if len(along):
            heights.append(0.5 * (bottom + top))
            faces.append(sign * float((sign * along).min()))
    if len(faces) < len(rows) // 2:
        return 0.0
    slope, offset = np.polyfit(heights, faces, 1)
    error = np.abs(np.array(faces) - slope * np.array(heights) - offset).max()
    return float(sign * np.arctan(slope)) if error < MAX_UNEVEN else 0.0


def _pad_frames(motion: JawMotion, postures: Sequence[int]) -> list[list[NDArray[np.float64]]]:
    """Return the orientation (3, 3) of the first pad of each side in postures."""
    data, frames = motion.shapes.posing.data, []
    for posture in postures:
        motion.posed(posture)
        frames.append([data.xmat[side[0]].reshape(3, 3).copy() for side in motion.pads])
    return frames


def _angle(one: list[NDArray[np.float64]], other: list[NDArray[np.float64]]) -> float:
    """Return the sum of the angles by which links have turned, rad."""
    cosines = [0.5 * (np.trace(a.T @ b) - 1.0) for a, b in zip(one, other, strict=True)]
    return float(np.arccos(np.clip(cosines, -1.0, 1.0)).sum())
