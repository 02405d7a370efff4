"""The pose of a camera is found from a board, with an error that is stated correctly."""

import numpy as np
import pytest
from scipy.spatial.transform import RigidTransform, Rotation

from eyehand.errors import InputError
from eyehand.perception.cameras import BoardView, HandEyeOptions, calibrate_hand_eye, charuco_board

from .board_scenes import CAMERA, board_scene, exact_views, moved

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
    assert found.reason == "the board is visible in 3 of 5 images, at least 4 needed"


def test_numbers_of_images_and_poses_must_agree():
    scene = board_scene("world", 5, 0)
    with pytest.raises(InputError, match="5 images have 4 poses"):
        calibrate_hand_eye(exact_views(scene, BOARD), scene.wrist[:4], CAMERA)
