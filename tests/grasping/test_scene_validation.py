"""An invalid image or scene stops clearing with a reason, and never as a clear table."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import RigidTransform, Rotation

from eyehand.apps.grasp.ground_truth_scene import ground_truth_scene
from eyehand.data_synth.scenes import TabletopObject
from eyehand.errors import InputError
from eyehand.grasping.cell import Cell
from eyehand.grasping.clearing import clear_table
from eyehand.grasping.observation import MAX_FRAMES, observe
from eyehand.grasping.scene_validation import MIN_UNEXPLAINED_AREA, unexplained_area, validate_scene
from eyehand.grasping.tray import Tray
from eyehand.perception import (
    CameraIntrinsics,
    Container,
    DepthFrame,
    SceneWarning,
    Segmentation,
    Superquadric,
    SupportPlane,
    Wall,
)

from .fake_robot import FakeRobot

TRAY = Tray(np.array([0.0, -0.45, 0.006]), (0.25, 0.3), 0.05)
VIEW = np.array([0.0, 0.5, 0.9])
LENS = CameraIntrinsics(50.0, 50.0, 9.5, 9.5, 20, 20)


def frame(share=1.0) -> DepthFrame:
    depth = np.ones((20, 20), np.float32)
    depth[: round(20 * (1 - share))] = 0.0
    return DepthFrame(depth, LENS)


def tilted(angle_deg: float, height: float = 0.0) -> SupportPlane:
    angle = np.radians(angle_deg)
    return SupportPlane(np.array([np.sin(angle), 0.0, np.cos(angle)]), -height)


@pytest.mark.parametrize(
    ("share", "support", "message"),
    [
        (1.0, tilted(0.0), ""),
        (0.5, tilted(0.0), ""),
        (1.0, tilted(2.5), ""),
        (1.0, tilted(0.0, 0.2), ""),
        (0.2, tilted(0.0), "20% of the pixels"),
        (1.0, None, "no level surface"),
        (1.0, tilted(3.5), "tilts by 3.5°"),
        (1.0, tilted(180.0), "tilts by 180.0°"),
        (1.0, tilted(0.0, -0.72), "0.73 m below the tray"),
        (1.0, tilted(0.0, 0.72), "0.71 m above the tray"),
    ],
)
def test_validation_reports_what_is_wrong(share, support, message):
    scene = replace(ground_truth_scene([], VIEW), support=support)
    reason = validate_scene(frame(share), scene, TRAY)
    assert message in reason
    assert bool(reason) == bool(message)


@pytest.mark.parametrize(("before", "valid"), [(0.002, True), (0.02, False), (None, False)])
def test_constant_image_shows_a_table_only_if_that_was_seen_before(before, valid):
    equal = SceneWarning("constant", "all readings are 0.850 m")
    scene = ground_truth_scene([], VIEW)
    scene = replace(scene, segmentation=replace(scene.segmentation, warnings=(equal,)))
    assert scene.warnings == (equal,)
    earlier = None if before is None else replace(scene, support=tilted(0.0, before))
    image = replace(frame(), T_world_camera=RigidTransform.from_translation(VIEW))
    assert validate_scene(image, scene, TRAY, earlier) == (
        "" if valid else "the scene is not reliable: all readings are 0.850 m"
    )


def raise_invalid_depth(_frame):
    raise InputError("depth is 0 everywhere")


def scene_without_table(_frame):
    return replace(ground_truth_scene([], VIEW), support=None)


@pytest.mark.parametrize(
    ("perceive", "message"),
    [(raise_invalid_depth, "0 everywhere"), (scene_without_table, "no table")],
)
def test_invalid_scene_stops_clearing_without_motion(perceive, message):
    robot = FakeRobot()
    start = robot.read().q
    report = clear_table(Cell(robot, perceive, TRAY))
    assert report.stop_reason.startswith("no ")
    assert message in report.stop_reason
    assert (report.picks, report.observations) == ((), 1)
    np.testing.assert_array_equal(robot.read().q, start)


def test_invalid_depth_image_stops_clearing_with_reason(monkeypatch):
    robot = FakeRobot()
    monkeypatch.setattr(robot, "capture", lambda: raise_invalid_depth(None))
    report = clear_table(Cell(robot, lambda _: ground_truth_scene([], VIEW), TRAY))
    assert report.stop_reason == "no valid depth image: depth is 0 everywhere"


def test_empty_table_is_clear():
    report = clear_table(Cell(FakeRobot(), lambda _: ground_truth_scene([], VIEW), TRAY))
    assert report.stop_reason == "clear"


FROM_ABOVE = RigidTransform.from_components([0.0, 0.0, 1.0], Rotation.from_euler("x", np.pi))
NEAR_LENS = CameraIntrinsics(200.0, 200.0, 39.5, 39.5, 80, 80)


def block_from_above(high: float, side: int):
    """Return frame and scene of a table 1 m below the camera with a block `side` pixels wide."""
    depth = np.ones((80, 80), np.float32)
    depth[30 : 30 + side, 30 : 30 + side] -= high
    labels = np.zeros(depth.shape, np.int32)
    scene = ground_truth_scene([], FROM_ABOVE.translation)
    scene = replace(scene, segmentation=Segmentation(labels, None, 0.0, {}))
    return DepthFrame(depth, NEAR_LENS, FROM_ABOVE), scene


def test_unsegmented_block_on_table_is_reported():
    frame, scene = block_from_above(high=0.1, side=3)
    # 9 pixels of 4.5 x 4.5 mm.
    assert unexplained_area(frame, scene, TRAY) == pytest.approx(9 * (0.9 / 200.0) ** 2, rel=1e-5)
    assert "2 cm² above it belong to no segmented object" in validate_scene(frame, scene, TRAY)


@pytest.mark.parametrize(("high", "side"), [(0.0, 0), (0.003, 8), (0.1, 2), (0.7, 8)])
def test_noise_flying_pixels_and_high_surfaces_are_accepted(high, side):
    frame, scene = block_from_above(high, side)
    assert unexplained_area(frame, scene, TRAY) <= MIN_UNEXPLAINED_AREA
    assert validate_scene(frame, scene, TRAY) == ""


def test_segmented_block_is_accepted():
    frame, scene = block_from_above(0.1, 8)
    labels = (frame.depth < 0.95).astype(np.int32)
    scene = replace(scene, segmentation=replace(scene.segmentation, labels=labels))
    assert unexplained_area(frame, scene, TRAY) == 0.0


def test_invalid_scene_is_captured_again_with_more_frames(monkeypatch):
    robot, captured = FakeRobot(), []
    whole = robot.capture()

    def capture_partly() -> DepthFrame:
        captured.append(len(captured))
        depth = np.where(np.arange(32) % 3 == len(captured) % 3, whole.depth, 0.0)
        return replace(whole, depth=depth.astype(np.float32))

    monkeypatch.setattr(robot, "capture", capture_partly)
    report = clear_table(Cell(robot, lambda _: ground_truth_scene([], VIEW), TRAY))
    assert (report.stop_reason, report.observations) == ("clear", 1)
    assert len(captured) == MAX_FRAMES


@pytest.mark.parametrize(
    ("kind", "stops"),
    [
        ("support_doubtful", True),
        ("support_unseen", True),
        ("camera", True),
        ("cut_by_image", False),
        ("container", False),
    ],
)
def test_scene_with_a_doubtful_or_unseen_support_stops_clearing(kind, stops):
    def perceive(_frame):
        scene = ground_truth_scene([], VIEW)
        warning = SceneWarning(kind, "a reason")
        return replace(scene, segmentation=replace(scene.segmentation, warnings=(warning,)))

    robot = FakeRobot()
    start = robot.read().q
    report = clear_table(Cell(robot, perceive, TRAY))
    assert report.stop_reason == ("the scene is not reliable: a reason" if stops else "clear")
    if stops:
        np.testing.assert_array_equal(robot.read().q, start)


def test_walls_of_a_container_are_explained():
    frame, scene = block_from_above(0.1, 8)
    points = FROM_ABOVE.apply(frame.points()[frame.depth < 0.95])
    low, high = points.min(axis=0), points.max(axis=0)
    corners = np.array([[x, low[1], z] for x, z in ((0, 0), (1, 0), (1, 1), (0, 1))])
    corners[:, 0] = np.where(corners[:, 0] > 0, low[0], high[0])
    corners[:, 2] *= 0.1
    floor = SupportPlane(np.array([0.0, 0.0, 1.0]), 0.0)
    wall = Wall(corners, float(high[1] - low[1]))
    assert wall.axes[1, 1] == pytest.approx(1.0)
    scene = replace(scene, containers=(Container(floor, (wall,), 0.1),))
    assert unexplained_area(frame, scene, TRAY) == 0.0


def block(half, centre):
    pose = RigidTransform.from_translation(centre)
    shape = Superquadric(np.array(half), (0.1, 0.1), pose, "box")
    return TabletopObject("block", shape, 0.1, (0.8, 0.2, 0.2))


@pytest.mark.parametrize("shift", [0.0, -0.006, 0.006])
@pytest.mark.parametrize("half_thickness", [0.003, 0.006])
def test_visible_walls_of_the_tray_are_no_objects_and_no_background(shift, half_thickness):
    """The camera sees one wall and an object that touches it; the calibration has an error."""
    outer = -0.3 + 2 * half_thickness
    wall = block([0.131, half_thickness, 0.025], [0.0, outer - half_thickness + shift, 0.031])
    can = block([0.02, 0.02, 0.04], [0.05, outer + 0.02 + shift, 0.04])
    scene = ground_truth_scene([wall, can], VIEW)
    post = np.array([[0.2, -0.1, 0.05]])
    scene = replace(scene, background=np.vstack([scene.objects[0].points, post]))

    observed, _, problem = observe(Cell(FakeRobot(), lambda _: scene, TRAY))

    assert observed is not None, problem
    assert [item.label for item in observed.objects] == [2]
    np.testing.assert_array_equal(observed.background, post)


def test_readings_of_the_robot_are_removed():
    """The image shows a level plane through the palm of the hand."""
    lens = CameraIntrinsics(20.0, 20.0, 15.5, 11.5, 32, 24)
    captured = []

    def perceive(frame):
        captured.append(frame)
        raise InputError("no scene is needed")

    robot = FakeRobot()
    cell = Cell(robot, perceive, TRAY)
    palm = cell.palm_pose().translation
    down = Rotation.from_euler("x", 180.0, degrees=True)
    camera = RigidTransform.from_components(palm + np.array([0.0, 0.0, 0.5]), down)
    robot.capture = lambda: DepthFrame(np.full((24, 32), 0.5, np.float32), lens, camera)
    observe(cell)

    frame = captured[0]
    assert frame.masked is not None
    np.testing.assert_array_equal(frame.masked, frame.depth == 0.0)
    assert frame.masked[11:13, 15:17].all()
    at = camera.apply(frame.points()[frame.depth > 0.0].astype(float))
    assert np.linalg.norm(at - palm, axis=1).min() > 0.02
    assert 0.02 < frame.masked.mean() < 0.5


def test_unsegmented_walls_of_the_tray_are_explained():
    frame, scene = block_from_above(0.1, 8)
    middle = FROM_ABOVE.apply(frame.points()[frame.depth < 0.95].mean(axis=0)) * (1.0, 1.0, 0.0)
    walls = replace(TRAY, centre=middle, size=(0.04, 0.04), wall_height=0.1)
    assert unexplained_area(frame, scene, TRAY) > MIN_UNEXPLAINED_AREA
    assert unexplained_area(frame, scene, walls) <= MIN_UNEXPLAINED_AREA


def test_content_that_stands_higher_than_the_walls_of_the_tray_is_explained():
    frame, scene = block_from_above(0.1, 8)
    middle = FROM_ABOVE.apply(frame.points()[frame.depth < 0.95].mean(axis=0)) * (1.0, 1.0, 0.0)
    tray = replace(TRAY, centre=middle, size=(0.04, 0.04), wall_height=0.02)
    assert unexplained_area(frame, scene, tray) <= MIN_UNEXPLAINED_AREA
