"""The simulated grasping cell.

`GraspWorld` joins table, tray, camera, objects and a `GraspRobot` (arm and hand) in one MuJoCo
model. `SimRobot` implements the robot protocol of `eyehand.grasping`.
"""

from ..arms import HAND, PALM_BEFORE_FLANGE_M
from .clutter_scene import CAMERA, MAX_RANGE, ClutterFamily, ClutterView, camera_pose, make_clutter
from .clutter_world import ClutterWorld
from .fingertip_pads import tip_array
from .grasp_cell import WORK_AREA_M, GraspCell, scene_options
from .grasp_execution import Execution, execute_grasp
from .grasp_robot import GraspRobot
from .grasp_world import GraspWorld
from .hand_description import (
    DESCRIPTION_SUFFIX,
    FingerDescription,
    HandDescription,
    read_description,
)
from .hand_frame import find_frame
from .pad_friction import grip_pads
from .rigid_hand import write_rigid_hand
from .robot_names import (
    ARMS,
    FOLDER_VARIABLE,
    HANDS,
    INCLUDED_ARM,
    make_robot,
    named_file,
    robot_file,
)
from .sim_robot import SimRobot
from .spec_assembly import match_options
from .synergy_drives import SynergyDrives
from .synergy_hand_model import synergy_hand_model
from .tendon_hand_model import tendon_hand_model

__all__ = [
    "ARMS",
    "CAMERA",
    "DESCRIPTION_SUFFIX",
    "FOLDER_VARIABLE",
    "HAND",
    "HANDS",
    "INCLUDED_ARM",
    "MAX_RANGE",
    "PALM_BEFORE_FLANGE_M",
    "WORK_AREA_M",
    "ClutterFamily",
    "ClutterView",
    "ClutterWorld",
    "Execution",
    "FingerDescription",
    "GraspCell",
    "GraspRobot",
    "GraspWorld",
    "HandDescription",
    "SimRobot",
    "SynergyDrives",
    "camera_pose",
    "execute_grasp",
    "find_frame",
    "grip_pads",
    "make_clutter",
    "make_robot",
    "match_options",
    "named_file",
    "read_description",
    "robot_file",
    "scene_options",
    "synergy_hand_model",
    "tendon_hand_model",
    "tip_array",
    "write_rigid_hand",
]
