"""Cameras that see less and less, or see it wrong: what is seen here is one noisy depth view."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from scipy.spatial.transform import RigidTransform, Rotation

from eyehand.control import CollisionWorld, PlannedApproach
from eyehand.control.tasks import Posture
from eyehand.data_synth.cell import GraspCell
from eyehand.data_synth.scenes import look_at
from eyehand.grasping.motion import execute

from ...bench.sweep import Sweep, Trial
from .event_sweeps import can
from .shape_sweeps import MM, PLACED
from .stress_trial import Bench, bench_of

if TYPE_CHECKING:
    from collections.abc import Callable

    from eyehand.data_synth.cell import SimRobot
    from eyehand.grasping import PickOptions
    from eyehand.perception import DepthFrame

SOMETHING = f"{PLACED}; where nothing can be seen, the robot says so and stays"
"""What is right where less and less is seen."""
IN_SIGHT = np.array([0.35, 0.55, 0.0, -1.35, 0.0, 0.9, 0.0])
"""A posture in which the arm hangs over the table between camera and objects, rad."""
WAY_SECONDS = 6.0
"""Longest way there, s."""
PATCH = 8
"""Readings get lost in squares of so many pixels: single ones would be filled in."""

Axis = Literal["x", "z"]


class OddEyedRobot:
    """A robot whose camera does not give what it should.

    Parameters
    ----------
    robot
        The sound one behind it.
    change
        What becomes of its depth images.
    """

    def __init__(self, robot: SimRobot, change: Callable[[DepthFrame], DepthFrame]) -> None:
        self._robot, self._change = robot, change

    def __getattr__(self, name: str) -> Any:
        return getattr(self._robot, name)

    def capture(self) -> DepthFrame:
        """Take a depth image, and change it."""
        return self._change(self._robot.capture())


def seeing_sweeps() -> tuple[Sweep[PickOptions], ...]:
    """Sweeps over what the camera gives."""
    return (
        Sweep(
            name="camera-roll",
            axis="camera turned about its line of sight, as it knows",
            unit="°",
            values=(0.0, 45.0, 90.0, 135.0, 180.0),
            holds_to=180.0,
            attempt=partial(_turned_camera, axis="z"),
            right=PLACED,
        ),
        Sweep(
            name="camera-away",
            axis="camera turned up, away from the table, as it knows",
            unit="°",
            values=(0.0, 10.0, 20.0, 30.0, 45.0, 90.0),
            holds_to=90.0,
            attempt=partial(_turned_camera, axis="x"),
            right=SOMETHING,
        ),
        Sweep(
            name="roll-untold",
            axis="camera turned about its line of sight, unknown to it",
            unit="°",
            values=(0.0, 1.0, 2.0, 4.0, 8.0, 20.0, 90.0, 180.0),
            holds_to=1.0,
            attempt=partial(_wrong_pose, axis="z"),
            right=PLACED,
        ),
        Sweep(
            name="pitch-untold",
            axis="camera tilted, unknown to it",
            unit="°",
            values=(0.0, 0.5, 1.0, 2.0, 4.0, 8.0, 20.0),
            holds_to=1.0,
            attempt=partial(_wrong_pose, axis="x"),
            right=PLACED,
        ),
        Sweep(
            name="lost-depth",
            axis="share of the image without a reading",
            unit="%",
            values=(0.0, 20.0, 40.0, 60.0, 80.0, 95.0, 100.0),
            holds_to=60.0,
            attempt=_lost_depth,
            right=SOMETHING,
        ),
        Sweep(
            name="robot-in-view",
            axis="arm on its way between camera and objects",
            unit="%",
            values=(0.0, 25.0, 50.0, 75.0, 100.0),
            holds_to=100.0,
            attempt=_robot_in_view,
            right=f"{PLACED}, looking again once the arm is out of sight if need be",
        ),
        Sweep(
            name="only-table",
            axis="empty table fills the image, camera from",
            unit="mm",
            values=(850.0, 600.0, 450.0, 350.0),
            holds_to=350.0,
            attempt=_only_table,
            right="says clear, and stays",
        ),
    )


def _turned_camera(angle_deg: float, seed: int, options: PickOptions, *, axis: Axis) -> Trial:
    usual = GraspCell()
    turned = replace(usual, T_world_camera=usual.T_world_camera * _turn(angle_deg, axis))
    bench = bench_of([can(seed)], seed, options, known=False, places=turned)
    return _says_so(bench)


def _wrong_pose(angle_deg: float, seed: int, options: PickOptions, *, axis: Axis) -> Trial:
    bench = bench_of([can(seed)], seed, options, known=False)
    turn = _turn(angle_deg, axis)

    def wrong(frame: DepthFrame) -> DepthFrame:
        assert frame.T_world_camera is not None
        return replace(frame, T_world_camera=frame.T_world_camera * turn)

    _change_frames(bench, wrong)
    return bench.clear().judged()


def _lost_depth(lost_pct: float, seed: int, options: PickOptions) -> Trial:
    bench = bench_of([can(seed)], seed, options, known=False)
    rng = np.random.default_rng([seed, 24])

    def holed(frame: DepthFrame) -> DepthFrame:
        rows, columns = frame.depth.shape
        lost = rng.random((-(-rows // PATCH), -(-columns // PATCH))) < 0.01 * lost_pct
        lost = np.kron(lost, np.ones((PATCH, PATCH), dtype=bool))[:rows, :columns]
        return replace(frame, depth=np.where(lost, 0.0, frame.depth).astype(frame.depth.dtype))

    _change_frames(bench, holed)
    return _says_so(bench)


def _robot_in_view(share_pct: float, seed: int, options: PickOptions) -> Trial:
    bench = bench_of([can(seed)], seed, options, known=False)
    cell = bench.cell
    goal = cell.home + 0.01 * share_pct * (IN_SIGHT - cell.home)
    hand = cell.robot.hand
    control = replace(options.control, dt=cell.robot.period, tolerance=0.02)
    world = CollisionWorld(cell.model(hand.excursions_at(hand.max_opening)), ())
    execute(cell, PlannedApproach(world, (Posture(goal, speed=2.0),), control), WAY_SECONDS)
    cell.step(np.zeros(len(cell.robot.joints)))
    return _says_so(bench)


def _only_table(distance_mm: float, seed: int, options: PickOptions) -> Trial:
    usual = GraspCell()
    middle = np.array([-0.1, 0.05, 0.0])
    eye = middle + MM * distance_mm * np.array([-0.3, 0.0, 0.954])
    near = replace(usual, T_world_camera=look_at(eye, middle))
    ended = bench_of([], seed, options, known=False, places=near).clear()
    right = ended.report.stop_reason == "clear" and not ended.picks
    return ended.judged(right, f"{len(ended.picks)} picks; {ended.report.stop_reason}")


def _says_so(bench: Bench) -> Trial:
    """Right is in the tray; where nothing was seen, not to have tried and not to say clear."""
    ended = bench.clear()
    return ended.judged(not ended.left or ended.refused)


def _change_frames(bench: Bench, change: Callable[[DepthFrame], DepthFrame]) -> None:
    robot = bench.robot
    bench.cell.robot = OddEyedRobot(robot, change)  # pyright: ignore[reportAttributeAccessIssue] - passes all else on


def _turn(angle_deg: float, axis: Axis) -> RigidTransform:
    vector = np.radians(angle_deg) * np.eye(3)["xyz".index(axis)]
    return RigidTransform.from_rotation(Rotation.from_rotvec(vector))
