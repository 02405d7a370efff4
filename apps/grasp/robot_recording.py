"""A recording of a demo with ROS 2 messages: robot, objects, scenes and grasps."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from scipy.spatial.transform import RigidTransform, Rotation

from eyehand.perception.cameras import ros_header, ros_transform

from ..ros_markers import triangle_marker, write_scene
from .body_meshes import body_meshes

if TYPE_CHECKING:
    from eyehand.data_synth.cell import SimRobot
    from eyehand.grasping import Cell, CycleInfo, PickReport, SelectedGrasp
    from eyehand.perception.cameras import RosWriter

    from .demo_record import Recorder

PERIOD_S = 0.05
"""Simulated time between two recorded states of the robot, s."""


class RobotRecording:
    """An observer of a demo that records it.

    Parameters
    ----------
    writer
        The file to write to.
    """

    def __init__(self, writer: RosWriter) -> None:
        self._writer = writer
        self._next = 0.0

    def join(self, cell: Cell, robot: SimRobot, recorder: Recorder) -> RobotRecording:
        """Record a cell: first the shapes of its bodies, each in the frame of its body."""
        self._cell, self._robot, self._recorder = cell, robot, recorder
        self._next = cell.reading.time
        now, markers = self._next, []
        self._bodies = body_meshes(robot.model)
        for body, shape in self._bodies.items():
            head = ros_header(now, self._name(body))
            rgba = np.asarray(shape.visual.vertex_colors)[shape.faces].reshape(-1, 4) / 255.0
            marker = triangle_marker(head, "body", body, shape.triangles, rgba)
            markers.append(marker | {"frame_locked": True})
        message = {"markers": markers}
        self._writer.write("/eyehand/cell", "visualization_msgs/MarkerArray", message, now)
        self._write_state(now)
        return self

    def on_cycle(self, cycle: CycleInfo) -> None:
        """Record the state of robot and objects when it is due."""
        if cycle.reading.time >= self._next:
            self._write_state(cycle.reading.time)

    def on_pick(self, choice: SelectedGrasp, report: PickReport | None) -> None:
        """Record the scene and the selected grasp before a pick."""
        frame, scene = self._recorder.frame, self._recorder.scene
        if report is None and frame is not None and scene is not None:
            plans = {choice.target.label: choice.plan}
            now, colours = self._cell.reading.time, self._recorder.colours
            write_scene(self._writer, frame, scene, plans, now, colours)

    def _write_state(self, now: float) -> None:
        self._next = now + PERIOD_S
        model, data = self._robot.model, self._robot.data
        moved = [number for number in range(model.njnt) if model.joint(number).name]
        states = {
            "header": ros_header(now, ""),
            "name": [model.joint(number).name for number in moved],
            "position": [float(data.qpos[model.jnt_qposadr[number]]) for number in moved],
            "velocity": [float(data.qvel[model.jnt_dofadr[number]]) for number in moved],
            "effort": [],
        }
        self._writer.write("/joint_states", "sensor_msgs/JointState", states, now)
        poses = [
            ros_transform(now, "world", self._name(body), self._pose(body))
            for body in self._bodies
            if body
        ]
        self._writer.write("/tf", "tf2_msgs/TFMessage", {"transforms": poses}, now)

    def _name(self, body: int) -> str:
        return self._robot.model.body(body).name

    def _pose(self, body: int) -> RigidTransform:
        data = self._robot.data
        turn = Rotation.from_quat(data.xquat[body], scalar_first=True)
        return RigidTransform.from_components(data.xpos[body], turn)
