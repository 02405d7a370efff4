"""Two opposing fingers of a hand as the jaws of a gripper.

The pads of thumb and finger are moved along one line from wide to touching. All other fingers stay
bent, or straight if they do not bend.
"""

from __future__ import annotations

import copy
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, cast

import numpy as np
from scipy.optimize import least_squares

from eyehand.errors import InputError

from .jaw_motion import JawMotion, between_jaws, measured_faces
from .posing import STEPS, Drives, Posing
from .tool_frame import HandShapes, JawSides

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from .links import Links

OPENING_STEP = 0.005
"""Step by which the opening grows until the fingers cannot follow, m."""
MAX_OPENING = 0.12
"""Maximum opening that is tried, m."""
PLACE_WEIGHT, DRIFT_WEIGHT = 300.0, 100.0
"""Weights of the distance between the tips, and of the way of their middle, 1/m."""
LEAN_WEIGHT, CROSS_WEIGHT, HOME_WEIGHT, STEP_WEIGHT = 3.0, 1.5, 0.2, 0.2
"""Weights of fingertips that lean along the closing axis, of tips that cross, of the distance of
joints from the middle of their ranges, and from the posture before, 1/rad."""
MIDDLE_OPENING = 0.03
"""Opening of the posture that defines the axes, m."""
MAX_DRIFT = 0.012
"""Maximum way of the middle between the tips across the approach, m."""
MAX_PLACE_ERROR = 1.5e-3
"""Maximum error of a fingertip's place, m."""
MAX_LEAN = np.sin(np.deg2rad(35.0))
"""Sine of the maximum angle by which a fingertip leans along the closing axis."""
BENT_SHARE = 0.9
"""Share of the range to which the other fingers are bent."""
TIP_LENGTH = 0.02
"""Length of a fingertip that touches objects, m."""
PAD_LENGTH = 0.024
"""Length from the tips in which the pads are searched, m."""
MIN_FREE = 0.015
"""Minimum free length of the fingertips in front of the palm and the other fingers, m."""
MIN_PINCH_STROKE = 0.02
"""Minimum stroke of a pair of fingers that is used as jaws, m."""


@dataclass(frozen=True, eq=False)
class _Finger:
    """A finger that pinches."""

    links: list[int]
    joints: list[int]
    tip: int
    """Outermost link with a shape."""
    centre: NDArray[np.float64]
    """Middle of the fingertip in the frame of its body, (3,), m."""
    base: NDArray[np.float64]
    """A point behind it on the fingertip's axis, (3,), m."""


def pinch_motion(
    links: Links, palm: int, branches: list[list[int]], names: Sequence[str] | None
) -> tuple[JawMotion, str]:
    """Return the motion of the two fingers that pinch with the largest stroke, and their names.

    Parameters
    ----------
    links, palm, branches
        The hand and its fingers.
    names
        Two bodies, one of each finger; None to try all pairs.

    Raises
    ------
    InputError
        If a name is unknown, or no two fingers can pinch.
    """
    joints = links.joints(link for branch in branches for link in branch)
    model = links.model
    middle = model.jnt_range[joints].mean(axis=1)
    posing = Posing(links, joints, Drives(tuple(joints), middle, middle))
    shapes = HandShapes(posing, palm, branches)
    pairs = [_pair(links, branches, names)] if names else _thumb_pairs(shapes, branches)
    found: list[tuple[float, JawMotion, str]] = []
    for one, other in pairs:
        fingers = _finger(shapes, one), _finger(shapes, other)
        pinched = _pinch_path(posing, shapes, fingers, branches)
        if pinched is None:
            continue
        motion = _as_jaws(shapes, fingers, *pinched, branches)
        low, high, _ = motion.pad_extent(0, 0)
        free = float(motion.tips[0]) - between_jaws(motion, 0, low, high)
        if free >= MIN_FREE or names:
            pair = " and ".join(links.name(finger.tip) for finger in fingers)
            found.append((float(motion.gaps[0]), motion, pair))
    if not found:
        pair = " and ".join(names) if names else "the thumb and any other finger"
        raise InputError(
            f"{pair} cannot oppose each other by {1e3 * MIN_PINCH_STROKE:.0f} mm in front of the "
            "palm; --pinch BODY BODY names the fingers"
        )
    _, motion, pair = max(found, key=lambda one: one[0])
    return motion, pair


def _thumb_pairs(
    shapes: HandShapes, branches: list[list[int]]
) -> list[tuple[list[int], list[int]]]:
    """Return the pairs of each finger with the thumb, which points away from the others."""
    if len(branches) == 2:
        return [(branches[0], branches[1])]
    shapes.pose(shapes.posing.start)
    directions = []
    for branch in branches:
        points = shapes.of_links(branch).reshape(-1, 3)
        tip = shapes.of_links([_tip_link(shapes, branch)]).reshape(-1, 3)
        direction = tip.mean(axis=0) - points.mean(axis=0)
        directions.append(direction / max(float(np.linalg.norm(direction)), 1e-9))
    likeness = (np.array(directions) @ np.array(directions).T).sum(axis=1)
    thumb = int(np.argmin(likeness))
    return [(branches[thumb], branch) for k, branch in enumerate(branches) if k != thumb]


def _tip_link(shapes: HandShapes, branch: list[int]) -> int:
    """Return the outermost link of a finger that has a shape."""
    shaped = [
        one for one in branch if any(len(shapes.triangles([g])) for g in shapes.link_geoms[one])
    ]
    return (shaped or branch)[-1]


def _pair(
    links: Links, branches: list[list[int]], names: Sequence[str]
) -> tuple[list[int], list[int]]:
    found = []
    for name in names:
        mine = [branch for branch in branches if name in _body_names(links, branch)]
        if not mine:
            known = ", ".join(links.name(branch[0]) for branch in branches)
            raise InputError(f"--pinch {name}: no finger has this body; the fingers are {known}")
        found.append(mine[0])
    if found[0] is found[1]:
        raise InputError(f"--pinch {' '.join(names)}: both bodies are of one finger")
    return found[0], found[1]


def _body_names(links: Links, branch: list[int]) -> set[str]:
    bodies = [body for body in range(links.model.nbody) if links.of_body[body] in branch]
    return {links.model.body(body).name for body in bodies}


def _finger(shapes: HandShapes, branch: list[int]) -> _Finger:
    """Return a finger with the middle and the axis of its fingertip."""
    links, data = shapes.links, shapes.posing.data
    shapes.pose(shapes.posing.start)
    tip = _tip_link(shapes, branch)
    turn, place = shapes.base_pose()
    points = shapes.of_links([tip]).reshape(-1, 3) @ turn.T + place
    local = (points - data.xpos[tip]) @ data.xmat[tip].reshape(3, 3)
    axis = np.eye(3)[int(np.argmax(np.abs(local.mean(axis=0))))]
    axis = axis * np.sign(local.mean(axis=0) @ axis)
    end = float((local @ axis).max())
    near = local[local @ axis > end - TIP_LENGTH]
    centre = 0.5 * (near.min(axis=0) + near.max(axis=0))
    joints = links.joints(branch)
    return _Finger(branch, joints, tip, centre, centre - TIP_LENGTH * axis)


def _pinch_path(
    posing: Posing,
    shapes: HandShapes,
    fingers: tuple[_Finger, _Finger],
    branches: list[list[int]],
) -> tuple[NDArray[np.float64], NDArray[np.float64]] | None:
    """Return postures from wide to touching and the tool's axes in the palm, or None."""
    model = posing.model
    posture = _parked(posing, fingers, branches)
    joints = fingers[0].joints + fingers[1].joints
    places = model.jnt_qposadr[joints].astype(int)
    low, high = model.jnt_range[joints].T
    if not (model.jnt_limited[joints].all() and (low < high).all()):
        return None
    home = 0.5 * (low + high)
    radius = sum(_thickness(shapes, posing, finger, posture) for finger in fingers)

    def state(values: NDArray[np.float64]) -> list[NDArray[np.float64]]:
        posture[places] = values
        posing.pose(posture)
        data = posing.data
        points = []
        for finger in fingers:
            turn, at = data.xmat[finger.tip].reshape(3, 3), data.xpos[finger.tip]
            points += [turn @ finger.centre + at, turn @ finger.base + at]
        return points

    def residuals(values, gap, axis, before, middle) -> NDArray[np.float64]:
        a, a0, b, b0 = state(values)
        apart = b - a
        along = apart / max(float(np.linalg.norm(apart)), 1e-9) if axis is None else axis
        place = apart - (gap + radius) * along
        leans = [(a - a0) @ along / TIP_LENGTH, (b - b0) @ along / TIP_LENGTH]
        crossed = ((a - a0) - (b - b0)) / TIP_LENGTH
        drift = np.zeros(3) if middle is None else 0.5 * (a + b) - middle
        weights = HOME_WEIGHT * (values - home), STEP_WEIGHT * (values - before)
        return np.concatenate(
            [
                PLACE_WEIGHT * place,
                DRIFT_WEIGHT * drift,
                LEAN_WEIGHT * np.array(leans),
                CROSS_WEIGHT * crossed,
                *weights,
            ]
        )

    def solved(gap, axis, before, middle):
        begin = np.clip(before, low + 1e-4, high - 1e-4)
        found = least_squares(
            cast("Any", residuals),
            begin,
            bounds=(low, high),
            args=(gap, axis, before, middle),
            max_nfev=60,
        )
        a, a0, b, b0 = state(found.x)
        along = (b - a) / max(float(np.linalg.norm(b - a)), 1e-9)
        line = along if axis is None else axis
        error = np.linalg.norm(b - a - (gap + radius) * line)
        leans = np.abs([(a - a0) @ line, (b - b0) @ line]) / TIP_LENGTH
        way = np.zeros(3) if middle is None else 0.5 * (a + b) - middle
        # Along the approach the tips may move: that is the advance of the tips.
        forward = (a - a0) + (b - b0)
        drift = np.linalg.norm(np.cross(way, forward)) / max(float(np.linalg.norm(forward)), 1e-9)
        good = error < MAX_PLACE_ERROR and leans.max() < MAX_LEAN and drift < MAX_DRIFT
        return found.x, bool(good), along, 0.5 * (a + b)

    values, good, axis, middle = solved(MIDDLE_OPENING, None, home, None)
    if not good:
        return None
    postures, gap = [], 0.0
    for share in (1.0, 0.5, 0.0):
        values, *_ = solved(share * MIDDLE_OPENING, axis, values, middle)
    while gap <= MAX_OPENING:
        values, good, *_ = solved(gap, axis, values, middle)
        if not good:
            break
        posture[places] = values
        postures.append(posture.copy())
        gap += OPENING_STEP
    if (len(postures) - 1) * OPENING_STEP < MIN_PINCH_STROKE:
        return None
    return np.array(postures[::-1]), _axes(shapes, posing, fingers, postures[0], axis)


def _parked(
    posing: Posing, fingers: tuple[_Finger, _Finger], branches: list[list[int]]
) -> NDArray[np.float64]:
    """Return the file's posture with all other fingers bent."""
    model = posing.model
    posture = posing.start.copy()
    for branch in branches:
        if branch in (fingers[0].links, fingers[1].links):
            continue
        for joint in posing.links.joints(branch):
            low, high = model.jnt_range[joint]
            # Hinges that bend have most of their range on one side; others spread the fingers.
            bends = model.jnt_limited[joint] and abs(low + high) > 0.5 * (high - low)
            end = high if abs(high) > abs(low) else low
            posture[model.jnt_qposadr[joint]] = BENT_SHARE * end if bends else 0.0
    return posture


def _thickness(
    shapes: HandShapes, posing: Posing, finger: _Finger, posture: NDArray[np.float64]
) -> float:
    """Return half of the least thickness of a fingertip, m."""
    posing.pose(posture)
    data = posing.data
    turn, place = shapes.base_pose()
    points = shapes.of_links([finger.tip]).reshape(-1, 3) @ turn.T + place
    local = (points - data.xpos[finger.tip]) @ data.xmat[finger.tip].reshape(3, 3)
    axis = (finger.centre - finger.base) / TIP_LENGTH
    near = local[local @ axis > (local @ axis).max() - TIP_LENGTH]
    sizes = np.ptp(near, axis=0)[np.abs(axis) < 0.5]
    return 0.5 * float(sizes.min())


def _axes(
    shapes: HandShapes,
    posing: Posing,
    fingers: tuple[_Finger, _Finger],
    closed: NDArray[np.float64],
    axis: NDArray[np.float64],
) -> NDArray[np.float64]:
    """Return closing axis, y and approach as columns in the palm's frame, (3, 3)."""
    posing.pose(closed)
    data = posing.data
    tips = [data.xmat[f.tip].reshape(3, 3) @ (f.centre - f.base) for f in fingers]
    forward = tips[0] + tips[1]
    x = -axis
    z = forward - (forward @ x) * x
    z /= np.linalg.norm(z)
    turn, _ = shapes.base_pose()
    return np.asarray(turn.T @ np.column_stack([x, np.cross(z, x), z]), dtype=np.float64)


def _as_jaws(
    shapes: HandShapes,
    fingers: tuple[_Finger, _Finger],
    path: NDArray[np.float64],
    axes: NDArray[np.float64],
    branches: list[list[int]],
) -> JawMotion:
    """Measure the pinching fingers as jaws; the first finger is at +x."""
    mine = fingers[0].links + fingers[1].links
    others = [link for branch in branches for link in branch if link not in mine]
    shapes = copy.copy(shapes)
    shapes.fixed_geoms = shapes.fixed_geoms + [g for one in others for g in shapes.link_geoms[one]]
    numbers = np.linspace(0, len(path) - 1, STEPS)
    full = np.array([np.interp(numbers, np.arange(len(path)), column) for column in path.T]).T
    jaws = JawSides(
        axes[:, 0],
        (fingers[0].links, fingers[1].links),
        ([fingers[0].links], [fingers[1].links]),
    )
    motion = JawMotion(
        shapes,
        jaws,
        axes,
        full,
        ((fingers[0].tip,), (fingers[1].tip,)),
        np.zeros((STEPS, 2)),
        np.zeros(STEPS),
        PAD_LENGTH,
    )
    measured_faces(motion)
    return motion
