"""The simulated grasping cell.

`GraspWorld` joins table, tray, camera, objects and a `GraspRobot` (arm and hand) in one MuJoCo
model. `SimRobot` implements the robot protocol of `eyehand.grasping`.
"""

from ..arms import HAND
from .clutter_scene import CAMERA, MAX_RANGE, ClutterFamily, camera_pose, make_clutter
from .clutter_world import ClutterWorld
from .grasp_cell import GraspCell, scene_options
from .grasp_execution import Execution, execute_grasp
from .grasp_robot import GraspRobot
from .grasp_world import GraspWorld
from .hand_description import DESCRIPTION_SUFFIX, FingerDescription, HandDescription
from .rigid_hand import write_rigid_hand
from .robot_names import ARMS, INCLUDED_ARM, make_robot, named_file
from .sim_robot import SimRobot
from .spec_assembly import match_options

__all__ = [
    "ARMS",
    "CAMERA",
    "DESCRIPTION_SUFFIX",
    "HAND",
    "INCLUDED_ARM",
    "MAX_RANGE",
    "ClutterFamily",
    "ClutterWorld",
    "Execution",
    "FingerDescription",
    "GraspCell",
    "GraspRobot",
    "GraspWorld",
    "HandDescription",
    "SimRobot",
    "camera_pose",
    "execute_grasp",
    "make_clutter",
    "make_robot",
    "match_options",
    "named_file",
    "scene_options",
    "write_rigid_hand",
]
