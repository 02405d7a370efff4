"""Two pads on two arms run over an unknown object, and what they felt (section 4.5)."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import RigidTransform, Rotation

from eyehand.data_synth.foam import Foam
from eyehand.data_synth.pad_scene import Arm, PadScene, PlacedObject, pad_scene
from eyehand.data_synth.touch_objects import TouchObject, unknown_object
from eyehand.tactile import ContactFeatures
from eyehand.tactile.phase_options import PhaseOptions
from eyehand.tactile.phases import TouchPhases
from eyehand.tactile.servo import ServoGoal, TactileServo
from eyehand.tactile.switches import ROLL

from .arm_rig import CYCLE, ArmRig, Hand, home_pose
from .felt_points import felt_points
from .start_posture import looking_down, start_posture

APART = 1.2
"""From one arm's base to the other's, which faces it, m: their pads at home are 0.2 m apart."""
DROP = 0.03
"""The object's top is this far below the pads at home, m."""
GAP = 0.008
"""From the object's top to the pads at the start, m: the ridge and the block stand out of it."""
FORCE = 3.0
"""With which each pad presses, N."""
OUTERMOST, LANES = 0.055, 5
"""Each pad has its half of the object: lanes from the middle out to here along x, m, and number
of lanes in each of the two directions."""
QUICK_LANES = 2
"""Lanes of a first look."""
HALF_WIDTH, HALF_DEPTH, SHARE = 0.1, 0.07, 0.6
"""Half axes of what the pads may assume of the object's plan, m, and how far out they go: a
guess of its size, as a camera gives it."""
SPEED, QUICK_SPEED = 0.025, 0.06
"""Of the pads along their lanes, m/s."""
GUIDE_GAIN, GUIDE_SPEED = 4.0, 0.1
"""Pull back to the lane, 1/s, and the fastest guidance, m/s."""
MOST_TILT_DEG, TILT_GAIN = 20.0, 8.0
"""Tilt from which rolling on is held against, degrees, and how strongly, 1/s: at an edge, rolling
would go on over it and take the pad to the side."""
HEADING_GAIN = 3.0
"""Pull of the pad's heading back to what it was at the start, 1/s: rolling turns it slowly."""
NOISE = 40.0
"""Pressure above which a tactel counts as touched, Pa."""
JUMP = 0.12
"""Way that the centre of pressure may jump, m: over the whole pad."""
LANDING_SECONDS = 2.0
"""Before the scan begins, s."""
EVERY = 5
"""Cycles from one image that gives points to the next."""


@dataclass(frozen=True)
class ExploreRun:
    """What was felt."""

    thing: TouchObject
    """The true object."""
    points: NDArray[np.float64]
    """(M, 3), felt points in the object's frame, m."""
    pad: NDArray[np.int64]
    """(M,), which pad felt each."""
    paths: tuple[NDArray[np.float64], ...]
    """Of each pad's middle, (K, 3), in the object's frame, m."""
    forces: NDArray[np.float64]
    """(K,), true forces during the scans, N."""
    outcomes: tuple[str, ...]
    """Of each pad: "done", or the name of what went wrong."""
    seconds: float
    """Time of both scans."""


def run_explore(seed: int, quick: bool = False) -> ExploreRun:
    """Scan an unknown object with two pads, in lanes along both directions."""
    thing = unknown_object()
    left = Arm(prefix="left_")
    far = RigidTransform.from_components([APART, 0.0, 0.0], Rotation.from_euler("z", np.pi))
    arms = (left, replace(left, T_world_base=far, prefix="right_"))
    top = home_pose().translation[2] - DROP
    origin = np.array([0.5 * APART, 0.0, top])
    scene = pad_scene((PlacedObject(thing, RigidTransform.from_translation(origin)),), arms)
    corners = _lanes(quick)
    speed = QUICK_SPEED if quick else SPEED
    turns = [_scan(scene, arms, number, origin, corners, speed, seed) for number in (0, 1)]
    return ExploreRun(
        thing,
        np.concatenate([turn.points for turn in turns]),
        np.repeat([0, 1], [len(turn.points) for turn in turns]),
        tuple(turn.path for turn in turns),
        np.concatenate([turn.forces for turn in turns]),
        tuple(turn.outcome for turn in turns),
        sum(turn.seconds for turn in turns),
    )


@dataclass(frozen=True)
class _Turn:
    points: NDArray[np.float64]
    path: NDArray[np.float64]
    forces: NDArray[np.float64]
    outcome: str
    seconds: float


def _scan(
    scene: PadScene,
    arms: tuple[Arm, ...],
    number: int,
    origin: NDArray[np.float64],
    corners: NDArray[np.float64],
    speed: float,
    seed: int,
) -> _Turn:
    """Scan one half with one arm, while the other waits at home: the pads would meet."""
    at_home = ArmRig(scene, arms, seed=seed)
    joints = np.split(at_home.simulation.joints, len(arms))
    place = origin + np.array([*_target(corners[0], number), GAP])
    joints[number] = start_posture(at_home.hands[number].robot, looking_down(place, np.pi / 2))
    rig = ArmRig(scene, arms, seed=seed, joints=np.concatenate(joints))
    hand = rig.hands[number]
    way = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(corners, axis=0), axis=1))])
    seconds = float(way[-1]) / speed
    # Between ridge, block and dome the contact jumps: that is what an unknown object is like.
    servo = TactileServo(ServoGoal(force=FORCE), ROLL)
    phases = TouchPhases(servo, PhaseOptions(jump=JUMP))
    phases.phase = "hold"
    foam, still = Foam(), np.zeros(6)
    points, path, forces = [np.zeros((0, 3))], [], []
    cycle = 0
    while rig.time < LANDING_SECONDS + seconds and phases.phase != "ended":
        at = max(rig.time - LANDING_SECONDS, 0.0) * speed
        middle = np.array([np.interp(at, way, corners[:, axis]) for axis in (0, 1)])
        guide = _guide(hand, origin[:2] + _target(middle, number))
        step = phases.step(_whole(hand), CYCLE, external=guide, measured=hand.twist)
        twists = [step.twist if k == number else still for k in range(len(arms))]
        moment = rig.step(*twists)[-1][number]
        cycle += 1
        if at > 0.0 and cycle % EVERY == 0 and phases.phase == "task":
            forces.append(moment.force)
            path.append(hand.pose.translation - origin)
            points.append(hand.pose.apply(felt_points(hand.reader.image, foam)) - origin)
    return _Turn(
        np.concatenate(points), np.array(path), np.array(forces), phases.outcome or "done", seconds
    )


def _lanes(quick: bool) -> NDArray[np.float64]:
    """Corners of a pad's way over its half, (K, 2), m, outwards positive: along y, then along x."""
    lanes = QUICK_LANES if quick else LANES
    corners = [(0.5 * OUTERMOST, 0.0)]
    for number, x in enumerate(np.linspace(0.0, OUTERMOST, lanes)):
        side = 1.0 if number % 2 else -1.0
        corners += [(x, side * HALF_DEPTH), (x, -side * HALF_DEPTH)]
    reach = SHARE * HALF_DEPTH
    for number, y in enumerate(np.linspace(-reach, reach, lanes)):
        ends = (0.0, OUTERMOST) if number % 2 else (OUTERMOST, 0.0)
        corners += [(ends[0], y), (ends[1], y)]
    # Within the plan's ellipse already here, or the pad would wait where its lane is cut short.
    return np.array([_inside(np.array(corner)) for corner in corners])


def _inside(place: NDArray[np.float64]) -> NDArray[np.float64]:
    half = SHARE * HALF_DEPTH * np.sqrt(max(1.0 - (place[0] / HALF_WIDTH) ** 2, 0.0))
    return np.array([place[0], np.clip(place[1], -half, half)])


def _target(middle: NDArray[np.float64], number: int) -> NDArray[np.float64]:
    """Where the left (0) or right (1) pad shall be, (2,), m: one mirrors the other."""
    return _inside(np.array([middle[0] if number else -middle[0], middle[1]]))


def _guide(hand: Hand, goal: NDArray[np.float64]) -> NDArray[np.float64]:
    """Give the outer motion (6,) towards a place of the plan, tangential to the pad."""
    pose = hand.pose
    pull = GUIDE_GAIN * (goal - pose.translation[:2])
    pull *= min(1.0, GUIDE_SPEED / max(float(np.linalg.norm(pull)), GUIDE_SPEED))
    rotation = pose.rotation.as_matrix()
    twist = np.zeros(6)
    twist[:2] = (rotation.T @ [*pull, 0.0])[:2]
    twist[3:5] = _back_up(rotation)
    # The y-axis is to stay above the world's y: x of the pad is then where it should be, too.
    twist[5] = HEADING_GAIN * float(np.arctan2(rotation[0, 1], rotation[1, 1]))
    return twist


def _whole(hand: Hand) -> ContactFeatures:
    """Give features of all that touches: a pad that rolls by one of two contacts never rests."""
    image = hand.reader.image
    if not hand.features:
        return hand.features
    felt = np.where(image.pressures > NOISE, image.pressures, 0.0)
    force = float(felt.sum()) * image.array.area
    centre = felt @ image.array.positions / max(float(felt.sum()), NOISE)
    area = float(np.count_nonzero(felt)) * image.array.area
    return replace(
        hand.features, force=force, centre=centre, area=area, pressure=force / max(area, 1e-9)
    )


def _back_up(rotation: NDArray[np.float64]) -> NDArray[np.float64]:
    """Give the turning (2,) about the pad's x and y that takes back what is tilted too far."""
    down = rotation.T @ [0.0, 0.0, -1.0]
    tilt = float(np.arccos(np.clip(down[2], -1.0, 1.0)))
    beyond = max(tilt - np.radians(MOST_TILT_DEG), 0.0)
    # About z x down: that turns z towards where down is.
    axis = np.array([-down[1], down[0]]) / max(float(np.hypot(down[0], down[1])), 1e-9)
    return TILT_GAIN * beyond * axis
