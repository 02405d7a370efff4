"""Tests of walls: large flat upright faces at the edge of a support."""

import numpy as np
import pytest
from synthetic_solids import CAMERA_HEIGHT, TABLE_AXES

from eyehand.perception.segmentation import SupportPlane
from eyehand.perception.segmentation.edge_boards import divided_boards
from eyehand.perception.segmentation.support_extent import Support
from eyehand.perception.segmentation.walls import MAX_BEHIND, MIN_LENGTH, is_board, is_side, is_wall

ORIGIN = -CAMERA_HEIGHT * TABLE_AXES[2]
EDGE = 1.0
"""Far edge of the support, m, table frame."""


def table_support() -> Support:
    corners = np.array([[-0.3, 0.4], [0.3, 0.4], [0.3, EDGE], [-0.3, EDGE]])
    hull = (corners + ORIGIN @ TABLE_AXES[:2].T).astype(np.float32)
    return Support(SupportPlane(TABLE_AXES[2], CAMERA_HEIGHT), hull, TABLE_AXES[:2], 0.7)


def face(length=0.4, y=EDGE, lean=0.0, noise=0.0):
    """Return readings of an upright face of 0.2 m height, camera frame."""
    x, z = np.meshgrid(np.linspace(-length / 2, length / 2, 15), np.linspace(0.0, 0.2, 12))
    rng = np.random.default_rng(0)
    depth = y + z * np.tan(lean) + noise * rng.normal(size=x.shape)
    points = np.column_stack([x.ravel(), depth.ravel(), z.ravel()])
    return points @ TABLE_AXES + ORIGIN


@pytest.mark.parametrize("lean", [0.0, 0.2, -0.2])
def test_long_face_at_edge_is_wall(lean):
    assert is_wall(face(lean=lean, noise=0.001), table_support())


@pytest.mark.parametrize(
    "points",
    [
        face(length=MIN_LENGTH - 0.02),
        face(y=EDGE - MAX_BEHIND - 0.02),
        face(lean=0.6),
        np.concatenate([face(), face() + 0.1 * TABLE_AXES[1]]),
    ],
    ids=["short", "support visible behind", "sloping", "two faces"],
)
def test_other_faces_are_no_walls(points):
    assert not is_wall(points, table_support())


def strip(x, length, height, low=0.0):
    """Return readings of a face of some length along y, or of a point-like one, camera frame."""
    y, z = np.meshgrid(np.linspace(0.5, 0.5 + length, 15), np.linspace(low, low + height, 12))
    points = np.column_stack([np.full(y.size, x), y.ravel(), z.ravel()])
    return points @ TABLE_AXES + ORIGIN


def test_thin_face_beside_the_support_is_a_side():
    assert is_side(strip(0.32, 0.2, 0.25), [table_support()])
    assert is_side(strip(0.32, 0.02, 0.25), [table_support()])


@pytest.mark.parametrize(
    "points",
    [strip(0.2, 0.2, 0.25), strip(0.32, 0.2, 0.05), strip(0.5, 0.2, 0.25), np.zeros((0, 3))],
    ids=["on the support", "low", "far away", "no readings"],
)
def test_other_faces_are_no_sides(points):
    assert not is_side(points, [table_support()])


def board(length, height, low):
    """Return readings of the front edge of a board, camera frame."""
    x, z = np.meshgrid(np.linspace(-length / 2, length / 2, 40), np.linspace(low, low + height, 5))
    return np.column_stack([x.ravel(), np.full(x.size, 0.5), z.ravel()]) @ TABLE_AXES + ORIGIN


@pytest.mark.parametrize(
    ("length", "height", "low", "expected"),
    [
        (0.6, 0.02, 0.25, True),
        (0.25, 0.02, 0.25, False),
        (0.6, 0.06, 0.25, False),
        (0.6, 0.02, 0.02, False),
    ],
    ids=["board", "short", "high", "on the support"],
)
def test_board_above_a_support(length, height, low, expected):
    assert is_board(board(length, height, low), table_support()) is expected


def test_pieces_at_one_height_are_a_divided_board():
    table, aside = table_support(), np.array([0.2, 0.0, 0.0]) @ TABLE_AXES
    pieces = [board(0.2, 0.02, 0.25) - aside, board(0.2, 0.02, 0.25) + aside]
    assert not any(is_board(piece, table) for piece in pieces)
    (heights,) = divided_boards(pieces, [table])
    assert heights + CAMERA_HEIGHT == pytest.approx([0.25, 0.27], abs=1e-6)
    assert divided_boards([pieces[0], board(0.2, 0.02, 0.3) + aside], [table]) == []
    shelf = table._replace(plane=SupportPlane(TABLE_AXES[2], CAMERA_HEIGHT - 0.24))
    assert divided_boards(pieces, [table, shelf]) == []
