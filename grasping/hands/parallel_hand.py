"""Description of a gripper with two parallel jaws, in the frame of its tool centre point."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.spatial.transform import RigidTransform, Rotation

from eyehand.errors import InputError

SENSES = ("width", "effort", "pad_forces", "tactile")
"""What a gripper can measure: the opening, the motor's force, the force of each pad, images."""
WIDTH_TOLERANCE = 0.001
"""Width beyond the stroke that a grasp may have, m."""
FINGER_SLACK = 0.005
"""Length by which the pad may be wider, or the depth longer than the boxes of the finger, m."""
PAD_SLACK = 0.002
"""Length by which boxes beside the pad may reach beyond its face, m, for rounded pads."""
MAX_FORCE = 1000.0
"""Greatest closing force of each jaw, N. Grippers for objects on a table press with 5 to 250 N."""
KINDS = ("parallel", "fingers")
"""A gripper with two jaws, and a hand of fingers of which some oppose the others as two jaws."""


@dataclass(frozen=True)
class HandBox:
    """A box with axes along those of the tool frame.

    Raises
    ------
    InputError
        If a corner is not 3 finite numbers, or `low` is not below `high`.
    """

    low: tuple[float, float, float]
    """Least x, y and z, m."""
    high: tuple[float, float, float]
    """Greatest x, y and z, m."""

    def __post_init__(self) -> None:
        for name in ("low", "high"):
            corner = tuple(float(value) for value in getattr(self, name))
            if len(corner) != 3 or not all(math.isfinite(value) for value in corner):
                raise InputError(f"{name} must be 3 finite numbers in m, got {list(corner)}")
            object.__setattr__(self, name, corner)
        if not all(low < high for low, high in zip(self.low, self.high, strict=True)):
            raise InputError(f"low {list(self.low)} must be below high {list(self.high)}")


@dataclass(frozen=True)
class ToolPose:
    """The tool frame of the closed hand in a body of the robot's file.

    Raises
    ------
    InputError
        If a number is not finite, or the quaternion has no length.
    """

    body: str
    """Name of the body or link."""
    position: tuple[float, float, float]
    """Origin of the tool frame, m."""
    quat_wxyz: tuple[float, float, float, float]
    """Rotation of the tool frame, w first."""

    def __post_init__(self) -> None:
        numbers = (*self.position, *self.quat_wxyz)
        if len(self.position) != 3 or len(self.quat_wxyz) != 4 or not any(self.quat_wxyz):
            raise InputError("a tool pose must have 3 numbers and a quaternion of 4")
        if not all(math.isfinite(value) for value in numbers):
            raise InputError(f"a tool pose must be finite, got {list(numbers)}")


@dataclass(frozen=True)
class HandJoint:
    """A joint of the gripper in its ROS driver.

    Raises
    ------
    InputError
        If a position is not finite.
    """

    name: str
    """Name of the joint."""
    open: float
    """Position at the maximum opening, m or rad."""
    closed: float
    """Position at opening 0, m or rad."""
    between: tuple[float, ...] = ()
    """Positions at equally spaced openings between those two, from closed to open, m or rad.
    Without them the position is linear in the opening."""

    def __post_init__(self) -> None:
        if not all(math.isfinite(value) for value in (self.open, self.closed, *self.between)):
            raise InputError(
                f"positions of joint {self.name!r} must be finite, got {self.open}, {self.closed}, "
                f"{list(self.between)}"
            )

    def at(self, share: float) -> float:
        """Return the position at a share of the maximum opening, m or rad."""
        positions = (self.closed, *self.between, self.open)
        return float(np.interp(share, np.linspace(0.0, 1.0, len(positions)), positions))


@dataclass(frozen=True)
class ParallelHand:
    """A gripper whose two jaws move along one line.

    The tool frame has z along the approach, x along the closing direction and its origin midway
    between the fingertips. A box of a finger is given for the jaw at +x, with x = 0 at the face of
    its pad. The other jaw is the mirror image at x = 0. An opening w moves the jaws by w/2 each.

    Raises
    ------
    InputError
        If a length or a force is outside its range, or boxes and lengths contradict each other.
    """

    name: str
    """Name of the hand."""
    stroke: float
    """Maximum distance between the pads, m."""
    finger_boxes: tuple[HandBox, ...]
    """Boxes of the finger at +x, with x = 0 at the pad's face, z = 0 at the fingertip."""
    finger_depth: float
    """Distance of the fingertips from what lies between the jaws behind them, m. An object can
    enter the hand as far."""
    pad_width: float
    """Width of a pad along y, m."""
    pad_height: float
    """Height of a pad along z, from the fingertip backwards, m."""
    palm_boxes: tuple[HandBox, ...]
    """Boxes of what does not move with the jaws: palm, motor, linkage."""
    min_opening: float = 0.0
    """Minimum distance between the pads, m."""
    force: tuple[float, float] = (0.0, 40.0)
    """Minimum and maximum closing force of each jaw, N."""
    camera_boxes: tuple[HandBox, ...] = ()
    """Boxes of a camera and its mount on the hand."""
    mount_distance: float = 0.0
    """Distance from the mounting face of the arm to the origin along z, m."""
    tip_advance: float = 0.0
    """Distance that the fingertips move forwards from the open to the closed hand, m. The origin is
    where the tips are farthest: those of the closed hand, if they move forwards."""
    middle_shift: tuple[float, float] = (0.0, 0.0)
    """x and y of the middle between the open pads, seen from that of the closed ones, m. It moves
    in proportion to the opening: by half of the stroke along x if the jaw at -x stands still."""
    kind: str = "parallel"
    """One of `KINDS`."""
    pre_shape: str = ""
    """Posture in which the fingers of a hand of kind "fingers" are two jaws. `joints` says how it
    closes."""
    tool: ToolPose | None = None
    """Where the tool frame is in the robot's file."""
    senses: tuple[str, ...] = ("width", "effort")
    """What the hand measures: some of `SENSES`."""
    joints: tuple[HandJoint, ...] = ()
    """Joints that a ROS driver commands."""
    source: str = ""
    """Where the numbers are from."""
    checked: bool = False
    """Whether the numbers were compared with a robot's file by a test."""
    notes: str = field(default="", compare=False)
    """What the boxes leave out."""

    def __post_init__(self) -> None:
        for name in ("stroke", "finger_depth", "pad_width", "pad_height"):
            value = getattr(self, name)
            if not 0.0 < value < 1.0:
                hint = ": are the lengths in m?" if value >= 1.0 else ""
                raise InputError(f"hand {self.name}: {name} must be 0 to 1 m, got {value}{hint}")
        if not 0.0 <= self.min_opening < self.stroke:
            raise InputError(
                f"hand {self.name}: min_opening must be from 0 to the stroke {self.stroke} m, "
                f"got {self.min_opening}"
            )
        if self.kind not in KINDS:
            raise InputError(
                f"hand {self.name}: kind must be {' or '.join(KINDS)}, got {self.kind!r}"
            )
        if math.hypot(*self.middle_shift) > self.stroke:
            raise InputError(
                f"hand {self.name}: middle_shift must be shorter than the stroke {self.stroke} m, "
                f"got {self.middle_shift}"
            )
        low, high = self.force
        if not 0.0 <= low <= high or not 0.0 < high < math.inf:
            raise InputError(
                f"hand {self.name}: force must be a range of positive N, got {self.force}"
            )
        if high > MAX_FORCE:
            most = f"at most {MAX_FORCE:g} N on each jaw"
            raise InputError(f"hand {self.name}: force must be {most}, got {high:g}: is it in N?")
        for name in ("finger_boxes", "palm_boxes"):
            if not getattr(self, name):
                raise InputError(
                    f"hand {self.name}: {name} must hold at least one box, got none: grasps keep "
                    "only boxes clear of objects"
                )
        unknown = [sense for sense in self.senses if sense not in SENSES]
        if unknown:
            raise InputError(
                f"hand {self.name}: unknown senses {', '.join(unknown)}; valid are "
                f"{', '.join(SENSES)}"
            )
        if not 0.0 <= self.mount_distance < 1.0:
            raise InputError(
                f"hand {self.name}: mount_distance must be >= 0 and below 1 m, got "
                f"{self.mount_distance}"
            )
        self._check_boxes()

    def _check_boxes(self) -> None:
        """Check that the finger lies beside the gap and holds the pad, behind it the palm."""
        low = np.min([box.low for box in self.finger_boxes], axis=0)
        high = np.max([box.high for box in self.finger_boxes], axis=0)
        if abs(high[2]) > 1e-3:
            raise InputError(
                f"hand {self.name}: the fingertips must end at z = 0, they end at {high[2]:.4f} m"
            )
        face = min(box.low[0] for box in self.finger_boxes if box.high[2] > -self.pad_height / 2)
        if not -PAD_SLACK <= face <= FINGER_SLACK:
            raise InputError(
                f"hand {self.name}: finger_boxes beside the pad must begin at its face, x = 0, "
                f"outside the gap, also of the open hand; they begin at {face:.4f} m"
            )
        width, length = float(high[1] - low[1]), float(high[2] - low[2])
        for name, most in (("pad_width", width), ("pad_height", length), ("finger_depth", length)):
            if getattr(self, name) > most + FINGER_SLACK:
                raise InputError(
                    f"hand {self.name}: {name} must be at most {most:.4g} m with these "
                    f"finger_boxes, got {getattr(self, name):.4g}"
                )
        front = max((box.high[2] for box in self.palm_boxes), default=-1.0)
        if front > 0.0:
            raise InputError(
                f"hand {self.name}: palm_boxes must lie behind the fingertips, at z < 0, they end "
                f"at {front:.4f} m"
            )
        between = [
            box.high[2]
            for box in self.palm_boxes
            if box.low[0] < 0.0 < box.high[0] and box.low[1] < 0.0 < box.high[1]
        ]
        if max(between, default=-1.0) > FINGER_SLACK - self.finger_depth:
            raise InputError(
                f"hand {self.name}: between the jaws the palm must end at z = -finger_depth = "
                f"{-self.finger_depth:.4g} m, palm_boxes end at {max(between):.4f} m"
            )

    def middle(self, opening: float) -> NDArray[np.float64]:
        """Return the middle between the pads, (3,), m, seen from that of the closed hand."""
        share = (opening - self.min_opening) / (self.stroke - self.min_opening)
        return max(share, 0.0) * np.array([*self.middle_shift, 0.0])

    def closed_pose(self, T_scene_tcp: RigidTransform, width: float) -> RigidTransform:
        """Return the tool frame of the closed hand, whose open pads are around a grasp.

        An arm moves this frame. It differs from `Grasp.T_scene_tcp` if only one jaw moves.

        Parameters
        ----------
        T_scene_tcp, width
            Pose and width of a grasp, m.

        Raises
        ------
        InputError
            If the hand does not open so wide.
        """
        if not 0.0 <= width <= self.stroke + WIDTH_TOLERANCE:
            raise InputError(f"width must be from 0 to the stroke {self.stroke:g} m, got {width:g}")
        return T_scene_tcp * RigidTransform.from_translation(-self.middle(width))

    def link_pose(self, T_scene_tcp: RigidTransform, width: float) -> RigidTransform:
        """Return the pose of the hand's link `tool.body` at a grasp.

        Parameters
        ----------
        T_scene_tcp, width
            Pose and width of a grasp, m.

        Raises
        ------
        InputError
            If the description does not say where the tool frame is in a link, or the hand does not
            open so wide.
        """
        if self.tool is None:
            raise InputError(
                f"the description of {self.name} has no `tool`: add the body and the pose of the "
                "tool frame in it, as `eyehand hand describe` does"
            )
        turn = Rotation.from_quat(self.tool.quat_wxyz, scalar_first=True)
        T_link_tcp = RigidTransform.from_components(self.tool.position, turn)
        return self.closed_pose(T_scene_tcp, width) * T_link_tcp.inv()

    def jaw_boxes(self, opening: ArrayLike) -> NDArray[np.float64]:
        """Return the corners of both fingers' boxes, (..., 2 n, 2, 3), m, for openings (...), m."""
        boxes = np.array([[box.low, box.high] for box in self.finger_boxes], dtype=np.float64)
        half = 0.5 * np.asarray(opening, dtype=np.float64)
        right = np.broadcast_to(boxes, (*half.shape, *boxes.shape)).copy()
        right[..., 0] += half[..., None, None]
        left = right.copy()
        left[..., 0] = -right[..., ::-1, 0]
        return np.concatenate([right, left], axis=-3)

    @cached_property
    def open_boxes(self) -> NDArray[np.float64]:
        """Low and high corners of all boxes of the open hand, (n, 2, 3), m."""
        boxes = np.concatenate([self.jaw_boxes(self.stroke), self.fixed_boxes()])
        # All grasps of all scenes share it.
        boxes.setflags(write=False)
        return boxes

    def joint_positions(self, opening: float) -> NDArray[np.float64]:
        """Return the positions of `joints` at an opening in m, (n,), m or rad."""
        return np.array([joint.at(opening / self.stroke) for joint in self.joints])

    def fixed_boxes(self) -> NDArray[np.float64]:
        """Return low and high corners of palm and camera, (n, 2, 3), m."""
        boxes = [[box.low, box.high] for box in (*self.palm_boxes, *self.camera_boxes)]
        return np.array(boxes, dtype=np.float64).reshape(-1, 2, 3)
