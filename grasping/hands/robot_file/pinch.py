"""Two opposing fingers of a hand as the jaws of a gripper.

The pads of thumb and finger are moved along one line from wide to touching. All other fingers stay
bent, or straight if they do not bend.
"""

from __future__ import annotations

import copy
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from eyehand.errors import InputError

from .coupled_joints import JointCouplings, joint_couplings
from .jaw_motion import JawMotion, measured_faces
from .links import Links
from .pad_area import between_jaws, opposed_pads
from .pinch_solver import TIP_LENGTH, Finger, Pinch
from .posing import STEPS, Drives, Posing
from .tool_frame import HandShapes, JawSides

OPENING_STEP = 0.005
"""Step by which the opening grows until the fingers cannot follow, m."""
MAX_OPENING = 0.12
"""Maximum opening that is tried, m."""
MIDDLE_OPENINGS = (0.03, 0.02, 0.01)
"""Openings of the posture that defines the axes, m. Fingers with few motors move on arcs: the next
smaller one is tried if they do not touch each other."""
BENT_SHARE = 0.9
"""Share of the range to which the other fingers are bent."""
PAD_LENGTH = 0.024
"""Length from the tips in which the pads are searched, m."""
MIN_FREE = 0.015
"""Minimum free length of the fingertips in front of the palm and the other fingers, m."""
MAX_FINGER_LENGTH = 0.3
"""Maximum distance along a finger from its first to its last joint, m. Arms are longer."""
MIN_PAD_WIDTH = 3e-3
"""Minimum width of the area in which two fingertips oppose each other, m."""
MIN_PINCH_STROKE = 0.02
"""Minimum stroke of a pair of fingers that is used as jaws, m."""


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
    longest = max(branches, key=lambda branch: _length(links, branch))
    if (length := _length(links, longest)) > MAX_FINGER_LENGTH:
        raise InputError(
            f"no gripper is found: the joints from {links.name(longest[0])} on are {length:.1f} m "
            f"long, as of an arm; a finger has at most {MAX_FINGER_LENGTH:g} m; --palm BODY names "
            "the body that carries the fingers"
        )
    middle = model.jnt_range[joints].mean(axis=1)
    posing = Posing(links, joints, Drives(tuple(joints), middle, middle))
    shapes = HandShapes(posing, palm, branches)
    pairs = [_pair(links, branches, names)] if names else _thumb_pairs(shapes, branches)
    found: list[tuple[float, JawMotion, str]] = []
    why = "no posture within the joint ranges brings the fingertips together along one line"
    for one, other in pairs:
        fingers = _finger(shapes, one), _finger(shapes, other)
        pinched = _pinch_path(posing, shapes, fingers, branches)
        if pinched is None:
            continue
        motion = _as_jaws(shapes, fingers, *pinched, branches)
        why = "their tips meet, but have no flat pads that face each other"
        try:
            least, most, _ = opposed_pads(motion)
        except InputError:
            continue
        if most - least < MIN_PAD_WIDTH:
            continue
        why = f"their tips meet less than {1e3 * MIN_FREE:.0f} mm in front of the other parts"
        low, high, _ = motion.pad_extent(0, 0)
        free = float(motion.tips[0]) - between_jaws(motion, 0, low, high)
        if free >= MIN_FREE or names:
            pair = " and ".join(links.name(finger.tip) for finger in fingers)
            found.append((float(motion.gaps[0]), motion, pair))
    if not found:
        pair = " and ".join(names) if names else "any two"
        known = ", ".join(links.name(branch[0]) for branch in branches)
        raise InputError(
            f"no gripper is found: of the fingers {known}, {pair} cannot oppose each other by "
            f"{1e3 * MIN_PINCH_STROKE:.0f} mm in front of the palm: {why}; --pinch BODY BODY names "
            "the fingers"
        )
    _, motion, pair = max(found, key=lambda one: one[0])
    return motion, pair


def _length(links: Links, branch: list[int]) -> float:
    """Return the distance along a finger from its first to its last joint, m."""
    model, longest = links.model, 0.0
    for link in branch:
        body, length = link, 0.0
        while links.of_body[body] in branch and body != branch[0]:
            length += float(np.linalg.norm(model.body_pos[body]))
            body = int(model.body_parentid[body])
        longest = max(longest, length)
    return longest


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


def _finger(shapes: HandShapes, branch: list[int]) -> Finger:
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
    return Finger(branch, joints, tip, centre, centre - TIP_LENGTH * axis)


def _pinch_path(
    posing: Posing,
    shapes: HandShapes,
    fingers: tuple[Finger, Finger],
    branches: list[list[int]],
) -> tuple[NDArray[np.float64], NDArray[np.float64]] | None:
    """Return postures from wide to touching and the tool's axes in the palm, or None."""
    couplings = joint_couplings(posing.model, list(posing.drives.joints))
    posture = _parked(posing, fingers, branches, couplings)
    radius = sum(_thickness(shapes, posing, finger, posture) for finger in fingers)
    pinch = Pinch(posing, fingers, posture, couplings, radius)
    low, high = pinch.bounds
    if not (posing.model.jnt_limited[pinch.joints].all() and (low < high).all()):
        return None
    for middle_opening in MIDDLE_OPENINGS:
        found = _opened(pinch, middle_opening)
        if found is not None:
            postures, axis = found
            return np.array(postures[::-1]), _axes(shapes, posing, fingers, postures[0], axis)
    return None


def _opened(
    pinch: Pinch, middle_opening: float
) -> tuple[list[NDArray[np.float64]], NDArray[np.float64]] | None:
    """Return postures from touching to wide and the closing axis, or None."""
    low, high = pinch.bounds
    values, good, axis, middle = pinch.solved(middle_opening, None, 0.5 * (low + high), None)
    if not good:
        return None
    for share in (1.0, 0.5, 0.0):
        values, *_ = pinch.solved(share * middle_opening, axis, values, middle)
    postures, gap = [], 0.0
    while gap <= MAX_OPENING:
        values, good, *_ = pinch.solved(gap, axis, values, middle)
        if not good:
            break
        postures.append(pinch.at(values).copy())
        gap += OPENING_STEP
    return (postures, axis) if (len(postures) - 1) * OPENING_STEP >= MIN_PINCH_STROKE else None


def _parked(
    posing: Posing,
    fingers: tuple[Finger, Finger],
    branches: list[list[int]],
    couplings: JointCouplings,
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
    couplings.complete(model, posture)
    return posture


def _thickness(
    shapes: HandShapes, posing: Posing, finger: Finger, posture: NDArray[np.float64]
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
    fingers: tuple[Finger, Finger],
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
    fingers: tuple[Finger, Finger],
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
