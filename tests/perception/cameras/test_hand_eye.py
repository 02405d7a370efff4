"""The pose of a camera is found from a board, with an error that is stated correctly."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import RigidTransform, Rotation

from eyehand.errors import InputError
from eyehand.perception.cameras import BoardView, HandEyeOptions, calibrate_hand_eye, charuco_board

from .board_scenes import CAMERA, BoardScene, board_scene, exact_views, moved

BOARD = charuco_board(7, 5, 0.03, 0.022)
MOUNTS = ("world", "wrist")


def noisy_trial(mount, seed, shift=0.2e-3, turn=3.5e-4, pixels=0.2):
    """Return the result of 15 noisy images, and its errors in m and rad."""
    rng = np.random.default_rng(seed)
    scene = board_scene(mount, 15, seed)
    views = [
        BoardView(view.pixels + rng.normal(0.0, pixels, view.pixels.shape), view.points)
        for view in exact_views(scene, BOARD)
    ]
    poses = [moved(pose, rng, shift, turn) for pose in scene.wrist]
    found = calibrate_hand_eye(views, poses, CAMERA, HandEyeOptions(mount))
    assert found.camera is not None
    error = scene.camera.inv() * found.camera
    return found, np.linalg.norm(error.translation), error.rotation.magnitude()


@pytest.mark.parametrize("mount", MOUNTS)
def test_exact_images_give_the_exact_pose(mount):
    scene = board_scene(mount, 6, 3)
    found = calibrate_hand_eye(
        exact_views(scene, BOARD), scene.wrist, CAMERA, HandEyeOptions(mount)
    )
    assert found.camera is not None
    error = scene.camera.inv() * found.camera
    assert np.linalg.norm(error.translation) < 1e-6
    assert error.rotation.magnitude() < 1e-6
    assert found.position_error < 2e-4


@pytest.mark.parametrize("mount", MOUNTS)
def test_fifteen_noisy_images_give_a_millimetre_and_a_tenth_of_a_degree(mount):
    trials = [noisy_trial(mount, seed) for seed in range(4)]
    assert np.median([shift for _, shift, _ in trials]) < 1e-3
    assert np.median([turn for _, _, turn in trials]) < np.deg2rad(0.1)


@pytest.mark.parametrize(
    ("changed", "noise", "accepted"),
    [
        ({"fx": 660.0, "fy": 660.0}, 0.2, False),
        ({"cx": 300.0}, 0.2, False),
        ({"fx": 606.0, "fy": 606.0}, 0.05, True),
    ],
)
def test_wrong_intrinsics_are_refused_and_doubtful_ones_named(changed, noise, accepted):
    """A focal length 1 % too large moved the camera by 5 mm, of stated 0.5 mm."""
    scene, rng = board_scene("world", 12, 3), np.random.default_rng(0)
    views = [
        BoardView(view.pixels + rng.normal(0.0, noise, view.pixels.shape), view.points)
        for view in exact_views(scene, BOARD)
    ]
    found = calibrate_hand_eye(views, scene.wrist, replace(CAMERA, **changed))
    assert bool(found) == accepted
    words = "the images of the board show fx, fy, cx, cy = "
    assert words in (found.warning if accepted else found.reason)


def test_inaccurate_positions_are_not_blamed_on_orientations():
    scene, rng = board_scene("world", 8, 3), np.random.default_rng(0)
    poses = [moved(pose, rng, 8e-3, 1e-5) for pose in scene.wrist]
    found = calibrate_hand_eye(exact_views(scene, BOARD), poses, CAMERA)
    assert not found
    assert "Check the positions of the robot" in found.reason
    assert "quaternion" not in found.reason


def test_stated_error_matches_the_true_one():
    trials = [noisy_trial("world", seed, shift=0.5e-3, turn=1e-3) for seed in range(6)]
    ratios = np.array([(shift / found.position_error) for found, shift, _ in trials])
    assert 0.5 < np.sqrt(np.mean(ratios**2)) < 1.6


def test_pose_of_another_image_is_left_out():
    scene = board_scene("world", 12, 5)
    wrist = list(scene.wrist)
    wrist[4] = wrist[4] * RigidTransform.from_translation([0.03, 0.0, 0.0])
    rng = np.random.default_rng(0)
    wrist = [moved(pose, rng, 0.2e-3, 3e-4) for pose in wrist]
    found = calibrate_hand_eye(exact_views(scene, BOARD), wrist, CAMERA)
    assert found.left_out == (4,)
    assert np.isnan(found.pose_errors[4]).all()
    assert found.camera is not None
    assert np.linalg.norm(found.camera.translation - scene.camera.translation) < 2e-3


def test_turns_about_one_axis_are_refused():
    scene = board_scene("wrist", 1, 0)
    turns = [
        scene.wrist[0] * RigidTransform.from_rotation(Rotation.from_rotvec([0.0, 0.0, angle]))
        for angle in np.linspace(-0.6, 0.6, 8)
    ]
    board = scene.wrist[0] * scene.camera * scene.seen[0]
    seen = [(wrist * scene.camera).inv() * board for wrist in turns]
    turned = type(scene)(scene.camera, turns, seen)
    found = calibrate_hand_eye(exact_views(turned, BOARD), turns, CAMERA, HandEyeOptions("wrist"))
    assert not found
    assert "one axis only" in found.reason


def test_too_few_views_are_refused():
    scene = board_scene("world", 5, 0)
    views = exact_views(scene, BOARD)
    nothing = BoardView(np.empty((0, 2)), np.empty((0, 3)))
    found = calibrate_hand_eye([*views[:3], nothing, nothing], scene.wrist, CAMERA)
    assert not found
    assert found.reason.startswith(
        "the board is visible in 3 of 5 images, at least 4 needed: check"
    )


def xyzw_read_as_wxyz(pose):
    rotation = Rotation.from_quat(pose.rotation.as_quat(), scalar_first=True)
    return RigidTransform.from_components(pose.translation, rotation)


def unchanged(pose):
    return pose


@pytest.mark.parametrize(
    ("mount", "given", "change", "words"),
    [
        ("world", "world", xyzw_read_as_wxyz, "They fit with quaternions in the order x, y, z, w"),
        ("wrist", "wrist", RigidTransform.inv, "or with inverted poses"),
        ("wrist", "world", unchanged, "They fit with --camera-on wrist"),
        ("wrist", "world", xyzw_read_as_wxyz, "x, y, z, w and --camera-on wrist"),
    ],
)
def test_usual_mistakes_are_refused_and_named(mount, given, change, words):
    scene = board_scene(mount, 6, 2)
    rng = np.random.default_rng(2)
    poses = [change(moved(pose, rng, 0.2e-3, 3.5e-4)) for pose in scene.wrist]
    found = calibrate_hand_eye(exact_views(scene, BOARD), poses, CAMERA, HandEyeOptions(given))
    assert not found
    assert found.board is None
    assert "the images do not fit the robot poses: residual" in found.reason
    assert words in found.reason


@pytest.mark.parametrize("mount", MOUNTS)
def test_poses_of_a_poor_robot_are_accepted(mount):
    found, _, _ = noisy_trial(mount, 1, 1e-3, 2e-3)
    assert not found.warning
    assert abs(found.board_scale - 1.0) < 3 * found.board_scale_error < 0.025


def test_poses_in_millimetres_are_refused():
    scene = board_scene("wrist", 5, 0)
    poses = [RigidTransform.from_components(1e3 * p.translation, p.rotation) for p in scene.wrist]
    with pytest.raises(InputError, match="is it in mm"):
        calibrate_hand_eye(exact_views(scene, BOARD), poses, CAMERA, HandEyeOptions("wrist"))


@pytest.mark.parametrize("mount", MOUNTS)
def test_wrong_board_size_is_refused_if_the_distance_varies(mount):
    scene = board_scene(mount, 12, 4)
    rng = np.random.default_rng(4)
    poses = [moved(pose, rng, 0.2e-3, 3.5e-4) for pose in scene.wrist]
    exact = exact_views(scene, BOARD)
    wrong = [BoardView(view.pixels, view.points * 25 / 30) for view in exact]
    found = calibrate_hand_eye(wrong, poses, CAMERA, HandEyeOptions(mount))
    assert not found
    assert found.wrong_size
    assert found.board_scale == pytest.approx(30 / 25, rel=0.01)


@pytest.mark.parametrize("mount", MOUNTS)
def test_equal_distances_do_not_check_the_board_size(mount):
    scene = board_scene(mount, 12, 4)
    rng = np.random.default_rng(4)
    middle = RigidTransform.from_translation([-0.105, -0.075, 0.0])
    # Each board turns about its middle, 0.38 m in front of the camera.
    level = [
        RigidTransform.from_components([0.0, 0.0, 0.38], one.rotation) * middle
        for one in scene.seen
    ]
    if mount == "wrist":
        fixed = scene.wrist[0] * scene.camera * scene.seen[0]
        wrist = [fixed * one.inv() * scene.camera.inv() for one in level]
    else:
        board = scene.wrist[0].inv() * scene.camera * scene.seen[0]
        wrist = [scene.camera * one * board.inv() for one in level]
    poses = [moved(pose, rng, 0.2e-3, 3.5e-4) for pose in wrist]
    views = exact_views(BoardScene(scene.camera, wrist, level), BOARD)
    found = calibrate_hand_eye(views, poses, CAMERA, HandEyeOptions(mount))
    assert found
    assert found.board_scale_error > 0.02
    assert "vary the distance by a third" in found.warning


def test_numbers_of_images_and_poses_must_agree():
    scene = board_scene("world", 5, 0)
    with pytest.raises(InputError, match="5 images have 4 poses"):
        calibrate_hand_eye(exact_views(scene, BOARD), scene.wrist[:4], CAMERA)
