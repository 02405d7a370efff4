"""Tests of the walls and covers of furniture, and of what remains of objects beside them."""

import numpy as np
from synthetic_solids import CAMERA_HEIGHT, TABLE_AXES, Box, Plate, exact_image, solid_frame

from eyehand.perception.segmentation import SupportPlane
from eyehand.perception.segmentation.frame_noise import NoiseProfile
from eyehand.perception.segmentation.furniture_walls import find_faces, remove_faces
from eyehand.perception.segmentation.parallel_planes import flat_readings
from eyehand.perception.segmentation.support_extent import locate_support

BOARD = Plate((-0.3, 0.3), (0.5, 0.9))
BACK = Box(0.0, 0.91, (0.62, 0.02, 0.3))
SIDE = Box(-0.31, 0.7, (0.02, 0.4, 0.3))
CUP = Box(0.1, 0.7, (0.08, 0.08, 0.1))


def faces_and_rest(solids):
    """Return the number of faces and the readings of each solid that remain, shares."""
    frame, labels = solid_frame(solids, (BOARD,))
    image = exact_image(frame)
    support = locate_support(SupportPlane(TABLE_AXES[2], CAMERA_HEIGHT, 5e-4), 0.8, image)
    assert support is not None
    readings = flat_readings(image, NoiseProfile(np.ones(1), np.full(1, 1e-3)))
    faces = find_faces(readings, [support])
    rest = remove_faces(labels > 0, image, faces)
    return len(faces), [rest[labels == k + 1].mean() for k in range(len(solids))]


def test_back_and_side_are_removed():
    count, (back, side, cup) = faces_and_rest([BACK, SIDE, CUP])
    assert count == 2
    assert back < 0.1
    assert side < 0.1
    assert cup > 0.95


def test_box_in_the_middle_is_no_wall():
    count, (box, cup) = faces_and_rest([Box(-0.1, 0.75, (0.25, 0.1, 0.3)), CUP])
    assert count == 0
    assert box == cup == 1.0


def test_small_box_at_the_edge_is_no_wall():
    count, (box,) = faces_and_rest([Box(0.0, 0.88, (0.15, 0.04, 0.2))])
    assert count == 0
    assert box == 1.0
