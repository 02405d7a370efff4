"""Explore an unknown object with two pads on two arms (section 4.5 of the chapter)."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import RigidTransform, Rotation

from eyehand.data_synth.pad import (
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
    MemoryFilter,
    PhaseOptions,
    ServoGoal,
    TactileServo,
    TouchPhases,
)

from .arm_rig import CYCLE, ArmRig, PadArm, RigOptions, SensorName, home_pose
from .commissioning import commissioned
from .felt_points import confirmed_points, felt_points, friction_shift
from .press_bench import pressed_decoder
from .start_posture import facing_down, start_posture

BASE_DISTANCE = 1.2
"""Distance between the bases of the facing arms, m. Their pads at home are 0.2 m apart."""
DROP = 0.03
"""Distance of the object's top below the pads at home, m."""
GAP = 0.008
"""Initial distance from the object's top to the pads, m. The ridge and the block rise above it."""
FORCE, MIN_FORCE = 3.0, 0.6
"""Default force of each pad, and minimum force on a corner, N."""
MEAN_PRESSURE, PEAK_PRESSURE = 1800.0, 6000.0
"""Maximum mean pressure of the imprint, and maximum pressure of one tactel, Pa. A pad presses less
on a ridge or a corner than on a face. The full force would compress the foam completely there and
saturate the tactels."""
EASE = 0.1
"""Filter coefficient of the goal force per cycle. The force follows an imprint within 40 ms."""
MAX_SATURATED_SHARE, MAX_MEAN_PRESSURE = 0.5, 8000.0
"""Fraction of saturated tactels and mean pressure, Pa, above which a pad stops. The imprint of an
edge is so small that a force of 3 N exceeds the default limits."""
SPEED, QUICK_SPEED = 0.025, 0.06
"""Speeds of the pads along their lanes, m/s."""
GUIDE_GAIN, GUIDE_SPEED = 4.0, 0.1
"""Position gain towards the lane, 1/s, and maximum guidance speed, m/s."""
MAX_TILT_DEG, TILT_GAIN = 40.0, 8.0
"""Tilt above which rolling is counteracted, degrees, and its gain, 1/s. At an edge, the pad would
otherwise roll over it and move sideways."""
HEADING_GAIN = 3.0
"""Gain towards the initial heading of the pad, 1/s. Rolling changes the heading slowly."""
LOST_FORCE, RETURN_SPEED = 0.1, 0.01
"""Force below which a pad has lost the object, N, and speed back to it, m/s: that of a landing. The
force is that of the image without the memory of the foam, which looks like a light contact."""
NOISE = 40.0
"""Minimum pressure of a touched tactel, Pa."""
JUMP = 0.12
"""Maximum jump of the centre of pressure, m: the whole pad."""
LANDING_SECONDS = 2.0
"""Time before the scan starts, s."""
EVERY = 10
"""Number of cycles between two images that contribute points."""

HALF_WIDTH, HALF_DEPTH, SHARE = 0.1, 0.07, 0.93
"""Half axes of the ellipse assumed for the object's plan, m, and the fraction of it that the pad
centres cover. A camera can provide such an estimate of the size."""
OUTERMOST, LANES = 0.085, 5
"""Outermost lane of a pad's half along x, m, and number of lanes in each of the two directions."""
QUICK_LANES = 2
"""Number of lanes per direction of a quick scan."""
START = 0.3
"""Landing position of a pad, as a fraction of the outermost lane."""


@dataclass(frozen=True)
class ExploreRun:
    """The result of an exploration."""

    touch_object: TouchObject
    """The true object."""
    points: NDArray[np.float64]
    """Measured points (M, 3) in the object frame, m."""
    pad: NDArray[np.int64]
    """Index (M,) of the pad that measured each point."""
    blurred: NDArray[np.float64]
    """Points (L, 3) from the same images without deconvolution, m."""
    paths: tuple[NDArray[np.float64], ...]
    """Path (K, 3) of each pad's centre in the object frame, m."""
    forces: NDArray[np.float64]
    """True forces (K,) during the scans, N."""
    outcomes: tuple[str, ...]
    """Outcome of each pad: "done" or the name of the failure."""
    seconds: float
    """Total time of both scans, s."""
    tilt_deg: float
    """Maximum tilt of a pad, degrees."""
    rim_mm: float
    """Maximum depth of a pad's rim below the top of the object's largest part, mm."""


def run_explore(seed: int, quick: bool = False, sensor: SensorName = "good") -> ExploreRun:
    """Scan an unknown object with two pads along lanes in both directions."""
    touch_object = unknown_object(seed)
    left = Arm(prefix="left_")
    far = RigidTransform.from_components([BASE_DISTANCE, 0.0, 0.0], Rotation.from_euler("z", np.pi))
    arms = (left, replace(left, T_world_base=far, prefix="right_"))
    top = home_pose().translation[2] - DROP
    origin = np.array([0.5 * BASE_DISTANCE, 0.0, top])
    scene = pad_scene((PlacedObject(touch_object, RigidTransform.from_translation(origin)),), arms)
    home = ArmRig(scene, arms, seed=seed)
    speed = QUICK_SPEED if quick else SPEED
    scans = [
        _scan(scene, arms, home, number, origin, lanes(quick), speed, (seed, sensor))
        for number in (0, 1)
    ]
    return ExploreRun(
        touch_object,
        np.concatenate([scan.points for scan in scans]),
        np.repeat([0, 1], [len(scan.points) for scan in scans]),
        np.concatenate([scan.blurred for scan in scans]),
        tuple(scan.path for scan in scans),
        np.concatenate([scan.forces for scan in scans]),
        tuple(scan.outcome for scan in scans),
        sum(scan.seconds for scan in scans),
        max(scan.tilt_deg for scan in scans),
        -1e3 * min(scan.lowest for scan in scans),
    )


@dataclass(frozen=True)
class _PadScan:
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
    pad: tuple[int, SensorName],
) -> _PadScan:
    """Scan one half with one arm. The other arm waits at home because the pads would collide."""
    path_distances = distances(corners)
    joints = np.split(home.simulation.joints, len(arms))
    # The heading is that of the home pose. Joint 7 thus stays far from its limits.
    heading = -0.5 * np.pi if number else 0.5 * np.pi
    place = origin + np.array([*position_on_path(corners, path_distances, 0.0, number), GAP])
    joints[number] = start_posture(home.hands[number].robot, facing_down(place, heading))
    options = RigOptions(sensor=pad[1])
    rig = ArmRig(scene, arms, seed=pad[0], options=options, joints=np.concatenate(joints))
    hand = rig.hands[number]
    seconds = float(path_distances[-1]) / speed
    # The contact jumps between ridge, block and dome, so the bounds of the phases are wide.
    servo = TactileServo(ServoGoal(force=FORCE), PRESETS["roll"], commissioned(pad[1]))
    options = PhaseOptions(
        jump=JUMP, saturated_share=MAX_SATURATED_SHARE, pressure_limit=MAX_MEAN_PRESSURE
    )
    phases = TouchPhases(servo, options)
    phases.phase = "hold"
    decoder, memory = pressed_decoder(pad[1], pad[0], number)
    filtered, still = MemoryFilter(memory), np.zeros(6)
    points, blurred, path, forces, tilt, lowest = [], [], [], [], 0.0, np.inf
    cycle, force, shift, contact = 0, FORCE, np.zeros(2), FORCE
    while rig.time < LANDING_SECONDS + seconds and phases.phase != "ended":
        travelled = max(rig.time - LANDING_SECONDS, 0.0) * speed
        guide = _guide(
            hand.pose,
            origin[:2] + position_on_path(corners, path_distances, travelled, number),
            heading,
            lost=contact < LOST_FORCE,
        )
        felt = _pad_features(hand)
        if felt:
            force += EASE * (_goal_force(hand, felt) - force)
            servo.goal = ServoGoal(force=force)
            normal, lever = max(felt.force, MIN_FORCE), servo.options.shear_lever
            shift = friction_shift(shift, hand.side_force, normal, lever)
        servo.side_force = hand.side_force
        step = phases.step(felt, CYCLE, external=guide, measured=hand.twist)
        twists = [step.twist if k == number else still for k in range(len(arms))]
        reading = rig.step(*twists)[-1][number]
        saturated = hand.reader.saturated
        image = filtered.correct(hand.reader.image.pressures, CYCLE, saturated)
        contact = float(np.maximum(image, 0.0).sum()) * hand.reader.image.array.area
        cycle += 1
        if travelled > 0.0 and cycle % EVERY == 0 and phases.phase == "task":
            pose = hand.pose
            forces.append(reading.force)
            path.append(pose.translation - origin)
            for sharpen, found in ((True, points), (False, blurred)):
                felt_here = felt_points(image, decoder, sharpen, saturated)
                found.append(pose.apply(felt_here - [*shift, 0.0]) - origin)
            tilt = max(tilt, _tilt(pose.rotation.as_matrix()))
            lowest = min(lowest, float((pose.apply(_RIM) - origin)[:, 2].min()))
    return _PadScan(
        confirmed_points(points),
        confirmed_points(blurred),
        np.array(path),
        np.array(forces),
        phases.outcome or "done",
        seconds,
        float(np.degrees(tilt)),
        lowest,
    )


def _guide(
    pose: RigidTransform, goal: NDArray[np.float64], heading: float, *, lost: bool
) -> NDArray[np.float64]:
    """Compute the external twist (6,) in the pad frame towards a goal position (2,).

    The linear part is tangential to the pad, m/s, and towards an object that the pad has lost. The
    angular part limits the tilt, rad/s.
    """
    pull = GUIDE_GAIN * (goal - pose.translation[:2])
    pull *= min(1.0, GUIDE_SPEED / max(float(np.linalg.norm(pull)), GUIDE_SPEED))
    rotation = pose.rotation.as_matrix()
    twist = np.zeros(6)
    twist[:2] = (rotation.T @ [*pull, 0.0])[:2]
    twist[2] = RETURN_SPEED if lost else 0.0
    twist[3:5] = _counter_tilt(rotation)
    # The y-axis shall keep its initial direction in the horizontal plane.
    y = rotation[0, 1] + 1j * rotation[1, 1]
    twist[5] = HEADING_GAIN * float(np.angle(y * np.exp(-1j * heading)))
    return twist


def _pad_features(hand: PadArm) -> ContactFeatures:
    """Compute the features over all touched tactels.

    A pad that rolls by only one of two contacts never comes to rest.
    """
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


def _goal_force(hand: PadArm, felt: ContactFeatures) -> float:
    """Compute the goal force for a contact, N. It is lower for a small or sharp imprint."""
    peak = max(float(hand.reader.image.pressures.max()), NOISE)
    limited = min(FORCE, MEAN_PRESSURE * felt.area, felt.force * PEAK_PRESSURE / peak)
    return max(limited, MIN_FORCE)


def _counter_tilt(rotation: NDArray[np.float64]) -> NDArray[np.float64]:
    """Compute the angular velocity (2,) about the pad's x and y that reduces too large a tilt."""
    down = rotation.T @ [0.0, 0.0, -1.0]
    beyond = max(_tilt(rotation) - np.radians(MAX_TILT_DEG), 0.0)
    # A rotation about z x down moves the z-axis towards down.
    axis = np.array([-down[1], down[0]]) / max(float(np.hypot(down[0], down[1])), 1e-9)
    return TILT_GAIN * beyond * axis


def _tilt(rotation: NDArray[np.float64]) -> float:
    """Return the angle between the pad's normal and straight down, rad."""
    return float(np.arccos(np.clip(-rotation[2, 2], -1.0, 1.0)))


_RIM = 0.042 * np.array([[x, y, 0.0] for x in (-1.0, 1.0) for y in (-1.0, 1.0)])
"""Corners of a pad's plate in the pad frame, m. The plate extends 2 mm beyond the foam."""


def lanes(quick: bool) -> NDArray[np.float64]:
    """Return the corners (K, 2) of a pad's path over its half, m, first along y, then along x.

    Positive x points outwards from the object's centre.
    """
    count = QUICK_LANES if quick else LANES
    corners = [(START * OUTERMOST, 0.0)]
    for number, x in enumerate(np.linspace(0.0, OUTERMOST, count)):
        end = HALF_DEPTH if number % 2 else -HALF_DEPTH
        corners += [(x, end), (x, -end)]
    reach = SHARE * HALF_DEPTH
    for number, y in enumerate(np.linspace(-reach, reach, count + 2)[1:-1]):
        ends = (0.0, OUTERMOST) if number % 2 else (OUTERMOST, 0.0)
        corners += [(ends[0], y), (ends[1], y)]
    # The corners are limited to the ellipse here. Otherwise the pad would wait on shortened lanes.
    return np.array([_inside(np.array(corner)) for corner in corners])


def position_on_path(
    corners: NDArray[np.float64], path_distances: NDArray[np.float64], travelled: float, number: int
) -> NDArray[np.float64]:
    """Compute the goal position (2,) of the left (0) or right (1) pad, m. The paths are mirrored.

    Parameters
    ----------
    corners, path_distances
        Corners of the path (see :func:`lanes`) and their distances along it (:func:`distances`).
    travelled
        Travelled distance along the path, m.
    number
        Index of the pad.
    """
    x, y = (np.interp(travelled, path_distances, corners[:, axis]) for axis in (0, 1))
    return _inside(np.array([x if number else -x, y]))


def distances(corners: NDArray[np.float64]) -> NDArray[np.float64]:
    """Compute the distance (K,) of each corner (K, 2) along the path, m."""
    return np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(corners, axis=0), axis=1))])


def _inside(place: NDArray[np.float64]) -> NDArray[np.float64]:
    half = HALF_DEPTH * np.sqrt(max(SHARE**2 - (place[0] / HALF_WIDTH) ** 2, 0.0))
    return np.array([place[0], np.clip(place[1], -half, half)])
