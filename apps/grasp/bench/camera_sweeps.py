"""Sweeps of cameras that see less, or that have a wrong pose."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import Any, Literal

import numpy as np
from scipy.spatial.transform import RigidTransform, Rotation

from eyehand.control import CollisionWorld, PlannedApproach
from eyehand.control.tasks import Posture
from eyehand.data_synth.cell import GraspCell, SimRobot
from eyehand.data_synth.scenes import look_at
from eyehand.grasping import PickOptions, execute
from eyehand.perception import DepthFrame

from ...bench.sweep import Sweep, Trial
from .shape_sweeps import MM, PLACED
from .stress_objects import can_on_table
from .stress_trial import StressCell, stress_cell

PLACED_OR_REFUSED = f"{PLACED}; if nothing is visible, a refusal without motion"
"""The requirement of sweeps that take the view away."""
ARM_IN_VIEW = np.array([0.35, 0.55, 0.0, -1.35, 0.0, 0.9, 0.0])
"""Joint configuration with the arm between camera and objects, rad."""
MAX_MOTION_SECONDS = 6.0
"""Time limit of the motion to that configuration, s."""
PATCH_PX = 8
"""Side of the square patches that lose their readings, px. Perception fills single pixels."""

Axis = Literal["x", "z"]


class AlteredCameraRobot:
    """A robot whose depth images are altered.

    Parameters
    ----------
    robot
        The robot that does the work.
    change
        Function that alters a depth image.
    """

    def __init__(self, robot: SimRobot, change: Callable[[DepthFrame], DepthFrame]) -> None:
        self._robot, self._change = robot, change

    def __getattr__(self, name: str) -> Any:
        return getattr(self._robot, name)

    def capture(self) -> DepthFrame:
        """Capture a depth image and alter it."""
        return self._change(self._robot.capture())


def camera_sweeps() -> tuple[Sweep[PickOptions], ...]:
    """Return the sweeps over the camera. Perception runs on one noisy depth image."""
    turned = (0.0, 45.0, 90.0, 135.0, 180.0)
    unknown_roll = (0.0, 1.0, 2.0, 4.0, 8.0, 20.0, 90.0, 180.0)
    seen_again = f"{PLACED}, captured again with the arm out of view if needed"
    return (
        Sweep("camera-roll", "known camera rotation about the optical axis", "°",
              turned, 180.0, partial(_turned_camera, axis="z"), PLACED),
        Sweep("camera-away", "known camera tilt away from the table", "°",
              (0.0, 10.0, 20.0, 30.0, 45.0, 90.0), 90.0,
              partial(_turned_camera, axis="x"), PLACED_OR_REFUSED),
        Sweep("roll-untold", "unknown camera rotation about the optical axis", "°",
              unknown_roll, 1.0, partial(_wrong_pose, axis="z"), PLACED),
        Sweep("pitch-untold", "unknown camera tilt", "°",
              (0.0, 0.5, 1.0, 2.0, 4.0, 8.0, 20.0), 1.0, partial(_wrong_pose, axis="x"), PLACED),
        Sweep("lost-depth", "share of the image without a reading", "%",
              (0.0, 20.0, 40.0, 60.0, 80.0, 95.0, 100.0), 60.0, _lost_depth, PLACED_OR_REFUSED),
        Sweep("robot-in-view", "motion of the arm into the view of the objects", "%",
              (0.0, 25.0, 50.0, 75.0, 100.0), 100.0, _robot_in_view, seen_again),
        Sweep("only-table", "distance of a camera that sees only the empty table", "mm",
              (850.0, 600.0, 450.0, 350.0), 350.0, _only_table, "reports clear and does not move"),
    )  # fmt: skip


def _turned_camera(angle_deg: float, seed: int, options: PickOptions, *, axis: Axis) -> Trial:
    default = GraspCell()
    turned = replace(default, T_world_camera=default.T_world_camera * _rotation(angle_deg, axis))
    stress = stress_cell([can_on_table(seed)], seed, options, known=False, geometry=turned)
    return _clear_or_refuse(stress)


def _wrong_pose(angle_deg: float, seed: int, options: PickOptions, *, axis: Axis) -> Trial:
    stress = stress_cell([can_on_table(seed)], seed, options, known=False)
    rotation = _rotation(angle_deg, axis)

    def wrong(frame: DepthFrame) -> DepthFrame:
        assert frame.T_world_camera is not None
        return replace(frame, T_world_camera=frame.T_world_camera * rotation)

    change_frames(stress, wrong)
    return stress.clear().trial()


def _lost_depth(lost_pct: float, seed: int, options: PickOptions) -> Trial:
    stress = stress_cell([can_on_table(seed)], seed, options, known=False)
    rng = np.random.default_rng([seed, 24])

    def holed(frame: DepthFrame) -> DepthFrame:
        rows, columns = frame.depth.shape
        lost = rng.random((-(-rows // PATCH_PX), -(-columns // PATCH_PX))) < 0.01 * lost_pct
        lost = np.kron(lost, np.ones((PATCH_PX, PATCH_PX), dtype=bool))[:rows, :columns]
        return replace(frame, depth=np.where(lost, 0.0, frame.depth).astype(frame.depth.dtype))

    change_frames(stress, holed)
    return _clear_or_refuse(stress)


def _robot_in_view(share_pct: float, seed: int, options: PickOptions) -> Trial:
    stress = stress_cell([can_on_table(seed)], seed, options, known=False)
    cell = stress.cell
    goal = cell.home + 0.01 * share_pct * (ARM_IN_VIEW - cell.home)
    control = replace(options.control, dt=cell.robot.period, tolerance=0.02)
    world = CollisionWorld(cell.model(cell.hand.posture(cell.hand.max_opening)), ())
    execute(cell, PlannedApproach(world, (Posture(goal, speed=2.0),), control), MAX_MOTION_SECONDS)
    cell.step(np.zeros(len(cell.robot.joints)))
    return _clear_or_refuse(stress)


def _only_table(distance_mm: float, seed: int, options: PickOptions) -> Trial:
    default = GraspCell()
    middle = np.array([-0.1, 0.05, 0.0])
    eye = middle + MM * distance_mm * np.array([-0.3, 0.0, 0.954])
    near = replace(default, T_world_camera=look_at(eye, middle))
    outcome = stress_cell([], seed, options, known=False, geometry=near).clear()
    right = outcome.report.cleared and not outcome.picks
    return outcome.trial(right, f"{len(outcome.picks)} picks; {outcome.report.stop_reason}")


def _clear_or_refuse(stress: StressCell) -> Trial:
    """Clear the table; pass if all is in the tray, or if the robot refused without a pick."""
    outcome = stress.clear()
    return outcome.trial(not outcome.left or outcome.refused)


def change_frames(stress: StressCell, change: Callable[[DepthFrame], DepthFrame]) -> None:
    """Alter every depth image that the robot of a cell captures."""
    robot = stress.robot
    stress.cell.robot = AlteredCameraRobot(robot, change)  # pyright: ignore[reportAttributeAccessIssue] - passes all else on


def _rotation(angle_deg: float, axis: Axis) -> RigidTransform:
    vector = np.radians(angle_deg) * np.eye(3)["xyz".index(axis)]
    return RigidTransform.from_rotation(Rotation.from_rotvec(vector))
