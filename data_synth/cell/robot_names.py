"""Robots by name: arms and hands of the MuJoCo Menagerie, and the included ones.

Files are searched in the folder that the environment variable ``EYEHAND_ROBOTS`` names, in the
folder ``robots`` of the working directory, and in the package `mujoco-menagerie`, which downloads
them on first use.
"""

from __future__ import annotations

import difflib
import math
import os
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

from scipy.spatial.transform import RigidTransform, Rotation

from eyehand.errors import InputError
from eyehand.grasping import ParallelHand, load_hand
from eyehand.grasping.hands import built_in_hands, describe_hand

from ..mujoco_import import import_mujoco
from .arm_check import check_arm, check_rest_posture
from .grasp_robot import GraspRobot
from .jaw_assembly import TOOL_FRAME

FOLDER_VARIABLE = "EYEHAND_ROBOTS"
"""Environment variable with the folder of the robots' files."""
BEHIND_M = 0.02
"""Largest distance of the fingertips behind the flange that is accepted, m. A hand that points
sideways may be a few millimetres behind."""
LOCAL_FOLDER = Path("robots")
"""Folder of the working directory that is searched as well."""


@dataclass(frozen=True)
class NamedArm:
    """An arm of the MuJoCo Menagerie."""

    file: str
    """MJCF file of the arm without a hand: folder and name."""
    rest: tuple[float, ...]
    """Rest posture in the cell, outside the camera's view and beside the tray, rad."""
    hand: str = ""
    """Default hand; empty if there is none."""
    whole: str = ""
    """MJCF file of the arm with that hand; empty if there is none."""
    flange: str = "attachment_site"
    """Site that carries the hand."""
    speed: tuple[float, ...] = ()
    """Published speed limit of each joint, rad/s; empty for the default."""
    acceleration: tuple[float, ...] = ()
    """Published acceleration limit of each joint, rad/s²; empty for the default."""


@dataclass(frozen=True)
class NamedHand:
    """A gripper of the MuJoCo Menagerie. Its description is built in under the same name."""

    file: str
    """MJCF file: folder and name."""
    depth: float = 0.0
    """Distance of the file's origin from the flange of an arm, m."""


INCLUDED_ARM, INCLUDED_HAND = "lbr", "own"
"""Names of the arm and the hand of the package."""
ARMS = {
    "panda": NamedArm(
        "franka_emika_panda/panda_nohand.xml",
        (-0.9, -0.4, 0.0, -2.2, 0.0, 1.9, -0.785),
        hand="panda",
        whole="franka_emika_panda/panda.xml",
        speed=(2.175, 2.175, 2.175, 2.175, 2.61, 2.61, 2.61),
        acceleration=(15.0, 7.5, 10.0, 12.5, 15.0, 20.0, 20.0),
    ),
    "ur5e": NamedArm(
        "universal_robots_ur5e/ur5e.xml",
        (2.24, -1.9, 2.1, -1.77, -1.5708, 0.0),
        speed=(math.pi,) * 6,
    ),
    "iiwa14": NamedArm(
        "kuka_iiwa_14/iiwa14.xml",
        (-0.9, -0.3, 0.0, -1.9, 0.0, 1.5, 0.0),
        speed=tuple(map(math.radians, (85, 85, 100, 75, 130, 135, 135))),
    ),
}
"""Arms by name, besides the included one."""
HANDS = {
    "panda": NamedHand("franka_emika_panda/hand.xml"),
    "2f85": NamedHand("robotiq_2f85/2f85.xml"),
    # The back of the palm is 30 mm behind the file's origin.
    "allegro": NamedHand("wonik_allegro/right_hand.xml", depth=0.03),
}
"""Grippers by name, besides the included hand."""


def make_robot(
    arm: str = INCLUDED_ARM, hand: str = "", mount: tuple[float, ...] | None = None
) -> GraspRobot:
    """Join an arm and a hand.

    Parameters
    ----------
    arm
        Name of an arm, or an MJCF file. A file without a hand needs the site ``attachment_site``.
    hand
        Name of a hand, or an MJCF file of a gripper; empty for the arm's own hand. The description
        beside a file, ``gripper.json`` of ``gripper.xml``, replaces the measured one.
    mount
        Pose of the hand's file in the arm's flange: x, y, z in m; roll, pitch, yaw in rad. None
        means the default of a name.

    Raises
    ------
    InputError
        If a name is unknown, a file is missing, or arm and hand cannot be joined.
    """
    if arm == INCLUDED_ARM and hand in ("", INCLUDED_HAND):
        if mount is not None:
            raise InputError("--mount is for another hand: the included one has its place")
        return GraspRobot()
    if hand == INCLUDED_HAND:
        raise InputError(f"the hand {INCLUDED_HAND!r} goes with the arm {INCLUDED_ARM!r} only")
    pose = None if mount is None else _mount_pose(mount)
    known = ARMS.get(arm)
    if known is None and arm != INCLUDED_ARM:
        return _robot_of_files(_file(arm, "arm", (INCLUDED_ARM, *ARMS)), hand, pose)
    hand = hand or (known.hand if known is not None else "")
    if not hand:
        raise InputError(f"the arm {arm!r} has no hand of its own: give --hand {_listed(HANDS)}")
    path, jaws, default = _gripper(hand)
    place = default if pose is None else pose
    if known is None:
        robot = GraspRobot()
        rest = tuple(robot.home)
        return jaw_robot(robot.arm, path, jaws, flange=robot.flange, rest=rest, mount=place)
    if hand == known.hand and pose is None:
        return jaw_robot(robot_file(known.whole), None, jaws, rest=known.rest)
    file = robot_file(known.file)
    return jaw_robot(file, path, jaws, flange=known.flange, rest=known.rest, mount=place)


def named_file(arm: str) -> Path:
    """Return the file of an arm without a hand: of a name in :data:`ARMS`, or a path itself.

    Raises
    ------
    InputError
        If it is neither, or the file of a name is in none of the places.
    """
    if arm in ARMS:
        return robot_file(ARMS[arm].file)
    return _file(arm, "arm", (INCLUDED_ARM, *ARMS))


def robot_file(name: str) -> Path:
    """Find a file of the MuJoCo Menagerie by its folder and name.

    Raises
    ------
    InputError
        If it is in none of the places.
    """
    given = os.environ.get(FOLDER_VARIABLE, "")
    folders = [Path(given)] if given else []
    for folder in (*folders, LOCAL_FOLDER):
        if (folder / name).is_file():
            return folder / name
    if given:
        raise InputError(f"{FOLDER_VARIABLE}={given}: there is no {name} in this folder")
    return _downloaded(name)


def _downloaded(name: str) -> Path:
    """Return a file of the package `mujoco-menagerie`."""
    try:
        import mujoco_menagerie  # pyright: ignore[reportMissingImports] - an extra
    except ImportError:
        raise InputError(
            f"there is no robot file {name}: install the robots with pip install "
            f"'eyehand[robots]', or name their folder in {FOLDER_VARIABLE}"
        ) from None
    folder, file = name.split("/", 1)
    try:
        return Path(mujoco_menagerie.get(folder).path(progress=None)) / file
    except (mujoco_menagerie.MenagerieError, OSError) as error:
        raise InputError(
            f"cannot download the files of {folder}: {' '.join(str(error).split())}; "
            f"without a connection, name a folder that holds {name} in {FOLDER_VARIABLE}"
        ) from None


def _robot_of_files(arm: Path, hand: str, mount: RigidTransform | None) -> GraspRobot:
    """Join an arm of a file with a gripper, or read a robot that contains one."""
    contained = mount is None and _contains_gripper(arm)
    if not hand and not contained:
        raise InputError(f"{arm} contains no gripper: give --hand {_listed(HANDS)}")
    if contained and (not hand or hand in HANDS):
        return jaw_robot(arm, None, load_hand(hand) if hand else _description(arm))
    path, jaws, default = _gripper(hand)
    if mount is None and hand in HANDS:
        mount = default
    if mount is None:
        raise InputError(
            f"the mount between {arm} and the hand {hand} is not known: "
            "give --mount x y z roll pitch yaw"
        )
    return jaw_robot(arm, path, jaws, mount=mount)


def _contains_gripper(arm: Path) -> bool:
    """Return whether a robot's file contains a gripper."""
    try:
        _ = GraspRobot(arm, None, jaws=load_hand("generic")).mechanism
    except InputError:
        return False
    return True


def _gripper(hand: str) -> tuple[Path, ParallelHand, RigidTransform]:
    """Return file, description and default mount of a gripper."""
    known = HANDS.get(hand)
    if known is not None:
        place = RigidTransform.from_translation([0.0, 0.0, known.depth])
        return robot_file(known.file), load_hand(hand), place
    path = _file(hand, "hand", (INCLUDED_HAND, *HANDS))
    return path, _description(path), RigidTransform.identity()


def _description(path: Path) -> ParallelHand:
    """Read the description of a gripper beside its MJCF file, or measure it in the file."""
    beside = path.with_suffix(".json")
    return load_hand(beside) if beside.is_file() else describe_hand(path).hand


def _file(text: str, what: str, names: Iterable[str]) -> Path:
    path = Path(text)
    if path.is_file():
        return path
    if what == "hand" and text in built_in_hands():
        raise InputError(
            f"the hand {text!r} can be planned for, but no place on an arm was tested for it: give "
            "the path of its MJCF file, and --mount"
        )
    near = difflib.get_close_matches(text, names, 1)
    hint = f"; did you mean {near[0]}?" if near else ""
    raise InputError(
        f"there is no {what} {text!r}: valid names are {_listed(names)}, or the path of an "
        f"MJCF file{hint}"
    )


def _mount_pose(mount: tuple[float, ...]) -> RigidTransform:
    if len(mount) != 6:
        raise InputError(f"--mount must be 6 numbers, x y z roll pitch yaw, got {list(mount)}")
    if max(map(abs, mount[3:])) > math.tau:
        raise InputError(f"roll, pitch and yaw of --mount must be in rad, got {list(mount[3:])}")
    rotation = Rotation.from_euler("xyz", mount[3:])
    return RigidTransform.from_components(list(mount[:3]), rotation)


def _listed(names: Iterable[str]) -> str:
    return ", ".join(names)


def jaw_robot(
    arm: Path,
    hand: Path | None,
    jaws: ParallelHand,
    *,
    flange: str = "attachment_site",
    rest: tuple[float, ...] | None = None,
    mount: RigidTransform | None = None,
) -> GraspRobot:
    """Join an arm and a gripper with two jaws.

    Parameters
    ----------
    arm
        MJCF file of the arm, or of the whole robot.
    hand
        MJCF file of the gripper; None if the arm's file contains it.
    jaws
        Description of the gripper.
    flange
        Site of the arm that carries the gripper.
    rest
        Arm joint angles at rest, rad; None means the keyframe ``home``.
    mount
        Pose of the gripper's file in the flange; None for the flange itself.

    Raises
    ------
    InputError
        If a file cannot be read, has no gripper or no flange, or its arm cannot move it.
    """
    made = GraspRobot(Path(arm), hand, TOOL_FRAME, flange, rest, jaws=jaws, mount=mount)
    model = made.compiled()
    check_arm(made.arm, model, made.joints, made.hand_joints, (), TOOL_FRAME)
    check_rest_posture(made.arm, model, made.joints, made.home)
    if hand is not None:
        data = import_mujoco().MjData(model)
        import_mujoco().mj_kinematics(model, data)
        carrier = data.site(flange)
        tips = (data.site(TOOL_FRAME).xpos - carrier.xpos) @ carrier.xmat.reshape(3, 3)
        ahead, beside = float(tips[2]), math.hypot(tips[0], tips[1])
        if ahead < -BEHIND_M:
            turn = ", by half a turn: 0 0 0 3.14 0 0" if -ahead > beside else ""
            raise InputError(
                f"{hand.name}: the fingertips are {-1e3 * ahead:.0f} mm behind the arm's flange: "
                f"turn the hand with --mount{turn}"
            )
    return made
