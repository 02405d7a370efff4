"""Boards are checked, drawn, and found again in rendered images."""

import cv2
import numpy as np
import pytest

from eyehand.errors import InputError
from eyehand.perception.cameras import charuco_board, checkerboard, detect_board

from .board_scenes import board_image, board_scene, project

BOARDS = [charuco_board(7, 5, 0.03, 0.022), checkerboard(7, 6, 0.03)]


@pytest.mark.parametrize("board", BOARDS, ids=["charuco", "checkerboard"])
@pytest.mark.parametrize("seed", range(4))
def test_corners_are_found_within_a_fifth_of_a_pixel(board, seed):
    (pose,) = board_scene("world", 1, seed).seen
    view = detect_board(board_image(pose, board), board)
    assert view
    error = np.linalg.norm(view.pixels - project(pose.apply(view.points)), axis=1)
    assert np.sqrt(np.mean(error**2)) < 0.2


def test_upside_down_checkerboard_keeps_its_first_corner():
    board = checkerboard(7, 6, 0.03)
    (pose,) = board_scene("world", 1, 0).seen
    image = cv2.rotate(board_image(pose, board), cv2.ROTATE_180)
    view = detect_board(np.asarray(image, np.uint8), board)
    expected = np.array([639.0, 479.0]) - project(pose.apply(view.points))
    np.testing.assert_allclose(view.pixels, expected, atol=0.6)


def test_hidden_charuco_corners_are_left_out():
    board = BOARDS[0]
    (pose,) = board_scene("world", 1, 1).seen
    image = board_image(pose, board)
    corners = project(pose.apply(board.corners))
    image[:, : int(np.median(corners[:, 0]))] = 255
    view = detect_board(image, board)
    assert 6 <= len(view.pixels) < len(board.corners)
    error = np.linalg.norm(view.pixels - project(pose.apply(view.points)), axis=1)
    assert error.max() < 1.0


@pytest.mark.parametrize("board", BOARDS, ids=["charuco", "checkerboard"])
def test_image_without_board_is_a_false_view(board):
    noise = np.random.default_rng(0).integers(0, 255, (120, 160), np.uint8)
    assert not detect_board(noise, board)


@pytest.mark.parametrize(
    ("build", "message"),
    [
        (lambda: checkerboard(7, 5, 0.03), "half turn"),
        (lambda: checkerboard(7, 6, 30.0), "0.001 to 1.0 m, got 30 m"),
        (lambda: checkerboard(7, 6, 3e-5), "0.001 to 1.0 m, got 3e-05 m: --square is in mm"),
        (lambda: checkerboard(2, 6, 0.03), "3 to 50 squares"),
        (lambda: charuco_board(7, 5, 0.03, 0.04), "smaller than the square"),
        (lambda: charuco_board(7, 5, 0.03, 0.02, "9X9"), "unknown dictionary '9X9'"),
        (
            lambda: charuco_board(40, 40, 0.03, 0.02, "4X4_50"),
            "has 800 markers, and the dictionary 4X4_50 holds 50",
        ),
        (lambda: checkerboard(7, 6, float("nan")), "got nan m"),
    ],
)
def test_bad_boards_are_refused(build, message):
    with pytest.raises(InputError, match=message):
        build()
