"""A recording of the demo holds robot, objects, scenes and grasps as ROS 2 messages."""

from types import SimpleNamespace

import numpy as np
import pytest

from eyehand.apps.grasp.bench.trial import GraspTrial, trial_cell
from eyehand.apps.grasp.body_meshes import body_meshes
from eyehand.apps.grasp.robot_recording import PERIOD_S, RobotRecording
from eyehand.apps.ros_markers import scene_writer

from ..test_ros_markers import messages

pytest.importorskip("mcap_ros2", reason="recordings of ROS 2 need the extra [ros]")


def test_recording_holds_robot_scene_and_grasp(single, cleared, tmp_path):
    cell, robot = trial_cell(single.objects, GraspTrial(family="single"))
    record, _ = cleared
    capture = record.captures[0]
    choice = SimpleNamespace(target=capture.target, plan=capture.pick.plan)
    with scene_writer(tmp_path / "a.mcap") as writer:
        assert writer is not None
        recording = RobotRecording(writer)
        seen = SimpleNamespace(frame=capture.frame, scene=capture.scene, colours=capture.colours)
        recording.join(cell, robot, seen)  # pyright: ignore[reportArgumentType] - stands in
        recording.on_pick(choice, None)  # pyright: ignore[reportArgumentType] - stands in
        for step in range(11):
            reading = SimpleNamespace(time=cell.reading.time + PERIOD_S / 2 * step)
            recording.on_cycle(SimpleNamespace(reading=reading))  # pyright: ignore[reportArgumentType]
        recording.on_pick(choice, capture.pick)  # pyright: ignore[reportArgumentType] - stands in
    found = messages(tmp_path / "a.mcap")
    states = found["/joint_states"]
    assert 5 <= len(states) <= 7
    names = list(states[0].name)
    at = names.index("robot_joint1")
    assert states[0].position[at : at + 7] == pytest.approx(cell.reading.q.tolist())
    (cell_markers,) = found["/eyehand/cell"]
    shapes = body_meshes(robot.model)
    assert len(cell_markers.markers) == len(shapes)
    for marker, (body, shape) in zip(cell_markers.markers, shapes.items(), strict=True):
        assert marker.header.frame_id == robot.model.body(body).name
        assert marker.frame_locked
        assert len(marker.points) == len(marker.colors) == 3 * len(shape.faces)
    placed = {one.child_frame_id: one for message in found["/tf"] for one in message.transforms}
    item = robot.world.objects[0].name
    where = placed[item].transform.translation
    position = robot.data.xpos[robot.model.body(item).id]
    np.testing.assert_allclose([where.x, where.y, where.z], position)
    assert "camera" in placed
    assert len(found["/eyehand/scene"]) == len(found["/eyehand/grasps"]) == 1
    assert len(found["/eyehand/grasps"][0].poses) == 1
