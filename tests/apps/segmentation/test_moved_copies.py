"""Mirrored and cropped copies: points keep their place in space, labels return to their pixels."""

import numpy as np

from eyehand.apps.segmentation.moved_copies import moved_copies
from eyehand.perception import CameraIntrinsics, DepthFrame

CAMERA = CameraIntrinsics(30.0, 32.0, 6.0, 5.5, 12, 10)


def frame():
    rng = np.random.default_rng(0)
    colour = rng.integers(0, 255, (10, 12, 3)).astype(np.uint8)
    return DepthFrame(rng.uniform(0.5, 1.0, (10, 12)).astype(np.float32), CAMERA, None, colour)


def test_labels_of_a_copy_return_to_their_pixels():
    original = frame()
    for copy in moved_copies(original):
        top, left = copy.cut
        restored = copy.restore((1e6 * copy.frame.depth).astype(np.int32))
        expected = (1e6 * original.depth).astype(np.int32)
        assert np.array_equal(restored[top:, left:], expected[top:, left:])
        assert not restored[:top].any()
        assert not restored[:, :left].any()


def test_rays_of_a_copy_are_those_of_the_original_or_their_mirror_images():
    original = frame()
    for copy in moved_copies(original):
        rows, columns = copy.reversed_axes
        signs = np.array([-1.0 if columns else 1.0, -1.0 if rows else 1.0, 1.0])
        rays = copy.frame.intrinsics.rays()[:: -1 if rows else 1, :: -1 if columns else 1]
        top, left = copy.cut
        assert np.allclose(rays * signs, CAMERA.rays()[top:, left:])


def test_there_are_six_copies_with_colour():
    copies = list(moved_copies(frame()))
    assert len({copy.frame.depth.tobytes() for copy in copies}) == 6
    for copy in copies:
        assert copy.frame.colour is not None
        assert copy.frame.colour.shape == (*copy.frame.depth.shape, 3)
