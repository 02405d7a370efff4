"""Two pads on two arms run over an unknown object, and what they felt (section 4.5)."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import RigidTransform, Rotation

from eyehand.data_synth.pad import (
    POINT_SPREAD_M,
    Arm,
    PadScene,
    PlacedObject,
    TouchObject,
    pad_scene,
    unknown_object,
)
from eyehand.tactile import (
    PRESETS,
    ContactFeatures,
    PhaseOptions,
    ServoGoal,
    TactileServo,
    TouchPhases,
)

from .arm_rig import CYCLE, ArmRig, Hand, home_pose
from .explore_lanes import distances, lanes, place_on_way
from .felt_points import felt_points
from .start_posture import facing_down, start_posture

APART = 1.2
"""From one arm's base to the other's, which faces it, m: their pads at home are 0.2 m apart."""
DROP = 0.03
"""The object's top is this far below the pads at home, m."""
GAP = 0.008
"""From the object's top to the pads at the start, m: the ridge and the block stand out of it."""
FORCE, MIN_FORCE = 3.0, 0.6
"""With which each pad presses, N, and how little it presses on a corner."""
MEAN_PRESSURE, PEAK_PRESSURE = 1800.0, 6000.0
"""Over the imprint, and of one tactel, Pa: on a ridge or a corner a pad presses less than on a
face, as the foam would be solid there, and tactels at their end, long before its whole force."""
EASE = 0.1
"""Share of the way to another force that is gone in a cycle: it follows an imprint in 40 ms."""
MAX_SATURATED_SHARE, MAX_MEAN_PRESSURE = 0.5, 8000.0
"""Share of tactels that may be at their end, and mean pressure, Pa, before a pad gives up: an
imprint on an edge is so small that a force of 3 N exceeds the usual bounds."""
SPEED, QUICK_SPEED = 0.025, 0.06
"""Of the pads along their lanes, m/s."""
GUIDE_GAIN, GUIDE_SPEED = 4.0, 0.1
"""Pull back to the lane, 1/s, and the fastest guidance, m/s."""
MAX_TILT_DEG, TILT_GAIN = 40.0, 8.0
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
EVERY = 10
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
    blurred: NDArray[np.float64]
    """(L, 3), points from the same images with the foam's spread left in them, m."""
    paths: tuple[NDArray[np.float64], ...]
    """Of each pad's middle, (K, 3), in the object's frame, m."""
    forces: NDArray[np.float64]
    """(K,), true forces during the scans, N."""
    outcomes: tuple[str, ...]
    """Of each pad: "done", or the name of what went wrong."""
    seconds: float
    """Time of both scans."""
    tilt_deg: float
    """Farthest that a pad leaned over, degrees."""
    rim_mm: float
    """Lowest that a pad's rim came, below the top of the object's largest part, mm."""


def run_explore(seed: int, quick: bool = False) -> ExploreRun:
    """Scan an unknown object with two pads, in lanes along both directions."""
    thing = unknown_object(seed)
    left = Arm(prefix="left_")
    far = RigidTransform.from_components([APART, 0.0, 0.0], Rotation.from_euler("z", np.pi))
    arms = (left, replace(left, T_world_base=far, prefix="right_"))
    top = home_pose().translation[2] - DROP
    origin = np.array([0.5 * APART, 0.0, top])
    scene = pad_scene((PlacedObject(thing, RigidTransform.from_translation(origin)),), arms)
    home = ArmRig(scene, arms, seed=seed)
    speed = QUICK_SPEED if quick else SPEED
    turns = [
        _scan(scene, arms, home, number, origin, lanes(quick), speed, seed) for number in (0, 1)
    ]
    return ExploreRun(
        thing,
        np.concatenate([turn.points for turn in turns]),
        np.repeat([0, 1], [len(turn.points) for turn in turns]),
        np.concatenate([turn.blurred for turn in turns]),
        tuple(turn.path for turn in turns),
        np.concatenate([turn.forces for turn in turns]),
        tuple(turn.outcome for turn in turns),
        sum(turn.seconds for turn in turns),
        max(turn.tilt_deg for turn in turns),
        -1e3 * min(turn.lowest for turn in turns),
    )


@dataclass(frozen=True)
class _Turn:
    points: NDArray[np.float64]
    blurred: NDArray[np.float64]
    path: NDArray[np.float64]
    forces: NDArray[np.float64]
    outcome: str
    seconds: float
    tilt_deg: float
    lowest: float


def _scan(
    scene: PadScene,
    arms: tuple[Arm, ...],
    home: ArmRig,
    number: int,
    origin: NDArray[np.float64],
    corners: NDArray[np.float64],
    speed: float,
    seed: int,
) -> _Turn:
    """Scan one half with one arm, while the other waits at home: the pads would meet."""
    way = distances(corners)
    joints = np.split(home.simulation.joints, len(arms))
    # As at home, for joint 7 to stay far from its limits.
    heading = -0.5 * np.pi if number else 0.5 * np.pi
    place = origin + np.array([*place_on_way(corners, way, 0.0, number), GAP])
    joints[number] = start_posture(home.hands[number].robot, facing_down(place, heading))
    rig = ArmRig(scene, arms, seed=seed, joints=np.concatenate(joints))
    hand = rig.hands[number]
    seconds = float(way[-1]) / speed
    # Between ridge, block and dome the contact jumps: that is what an unknown object is like.
    servo = TactileServo(ServoGoal(force=FORCE), PRESETS["roll"])
    options = PhaseOptions(
        jump=JUMP, saturated_share=MAX_SATURATED_SHARE, pressure_limit=MAX_MEAN_PRESSURE
    )
    phases = TouchPhases(servo, options)
    phases.phase = "hold"
    foam, still, spread = scene.pad.foam, np.zeros(6), POINT_SPREAD_M
    points, blurred = [np.zeros((0, 3))], [np.zeros((0, 3))]
    path, forces, tilt, lowest = [], [], 0.0, np.inf
    cycle, force = 0, FORCE
    while rig.time < LANDING_SECONDS + seconds and phases.phase != "ended":
        gone = max(rig.time - LANDING_SECONDS, 0.0) * speed
        guide = _guide(hand.pose, origin[:2] + place_on_way(corners, way, gone, number), heading)
        felt = _whole(hand)
        if felt:
            force += EASE * (_fitting_force(hand, felt) - force)
            servo.goal = ServoGoal(force=force)
        step = phases.step(felt, CYCLE, external=guide, measured=hand.twist)
        twists = [step.twist if k == number else still for k in range(len(arms))]
        moment = rig.step(*twists)[-1][number]
        cycle += 1
        if gone > 0.0 and cycle % EVERY == 0 and phases.phase == "task":
            pose = hand.pose
            forces.append(moment.force)
            path.append(pose.translation - origin)
            image = hand.reader.image
            points.append(pose.apply(felt_points(image, foam, spread)) - origin)
            blurred.append(pose.apply(felt_points(image, foam)) - origin)
            tilt = max(tilt, _tilt(pose.rotation.as_matrix()))
            lowest = min(lowest, float((pose.apply(_RIM) - origin)[:, 2].min()))
    return _Turn(
        np.concatenate(points),
        np.concatenate(blurred),
        np.array(path),
        np.array(forces),
        phases.outcome or "done",
        seconds,
        float(np.degrees(tilt)),
        lowest,
    )


def _guide(pose: RigidTransform, goal: NDArray[np.float64], heading: float) -> NDArray[np.float64]:
    """Give the outer motion (6,) towards a place of the plan, tangential to the pad."""
    pull = GUIDE_GAIN * (goal - pose.translation[:2])
    pull *= min(1.0, GUIDE_SPEED / max(float(np.linalg.norm(pull)), GUIDE_SPEED))
    rotation = pose.rotation.as_matrix()
    twist = np.zeros(6)
    twist[:2] = (rotation.T @ [*pull, 0.0])[:2]
    twist[3:5] = _back_up(rotation)
    # Seen from above, the y-axis is to stay where it was: how far it has turned from there.
    y = rotation[0, 1] + 1j * rotation[1, 1]
    twist[5] = HEADING_GAIN * float(np.angle(y * np.exp(-1j * heading)))
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


def _fitting_force(hand: Hand, felt: ContactFeatures) -> float:
    """Give the force for a contact, N: less where the imprint is small or sharp."""
    peak = max(float(hand.reader.image.pressures.max()), NOISE)
    wish = min(FORCE, MEAN_PRESSURE * felt.area, felt.force * PEAK_PRESSURE / peak)
    return max(wish, MIN_FORCE)


def _back_up(rotation: NDArray[np.float64]) -> NDArray[np.float64]:
    """Give the turning (2,) about the pad's x and y that takes back what is tilted too far."""
    down = rotation.T @ [0.0, 0.0, -1.0]
    beyond = max(_tilt(rotation) - np.radians(MAX_TILT_DEG), 0.0)
    # About z x down: that turns z towards where down is.
    axis = np.array([-down[1], down[0]]) / max(float(np.hypot(down[0], down[1])), 1e-9)
    return TILT_GAIN * beyond * axis


def _tilt(rotation: NDArray[np.float64]) -> float:
    """Give how far a pad looks away from straight down, rad."""
    return float(np.arccos(np.clip(-rotation[2, 2], -1.0, 1.0)))


_RIM = 0.042 * np.array([[x, y, 0.0] for x in (-1.0, 1.0) for y in (-1.0, 1.0)])
"""Corners of a pad's plate, m: it stands out 2 mm all around the foam."""
