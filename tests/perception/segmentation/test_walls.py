"""Tests of walls: large flat upright faces at the edge of a support."""

import numpy as np
import pytest
from synthetic_solids import CAMERA_HEIGHT, TABLE_AXES

from eyehand.perception.segmentation import SupportPlane
from eyehand.perception.segmentation.support_extent import Support
from eyehand.perception.segmentation.walls import MAX_BEHIND, MIN_LENGTH, is_wall

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
