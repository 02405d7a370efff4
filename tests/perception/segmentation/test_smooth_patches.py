"""Links, normals and connected patches equal what whole-array NumPy gives."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from random_planes import NOISE, random_planes
from scipy import ndimage
from solids import Box, exact_image, solid_frame

from eyehand.perception import CameraIntrinsics, SegmentationOptions
from eyehand.perception.segmentation.local_planes import fit_local_planes, plane_normals
from eyehand.perception.segmentation.smooth_patches import (
    MIN_PATCH,
    label_patches,
    linked_pixels,
    links,
)

CAMERA = CameraIntrinsics(20.0, 21.0, 8.0, 7.0, 17, 14)


def reference_normals(planes, camera):
    """Normals of q = n·(x, y, 1) as the solution of its three equations."""
    v, u = np.indices(planes.value.shape)
    x, y = planes.slope_u * camera.fx, planes.slope_v * camera.fy
    z = planes.value - x * (u - camera.cx) / camera.fx - y * (v - camera.cy) / camera.fy
    n = -np.stack([x, y, z], axis=-1)
    lengths = np.linalg.norm(n, axis=-1, keepdims=True)
    return np.where(planes.value[..., None] > 0, n / np.maximum(lengths, 1e-9), 0.0)


def reference_links(planes, normals, min_cosine, max_gap):
    """Links of all pixels at once, in both directions, in single precision as the kernel's."""
    value, known = planes.value, planes.value > 0
    linked = np.zeros(value.shape, bool)
    here = np.s_[:-1, :-1]
    linked[here] = known[here]
    for there, slope in ((np.s_[:-1, 1:], planes.slope_u), (np.s_[1:, :-1], planes.slope_v)):
        ahead = np.abs(value[here] + slope[here] - value[there])
        back = np.abs(value[there] - slope[there] - value[here])
        cosine = (normals[here] * normals[there]).sum(axis=-1)
        linked[here] &= known[there] & (np.maximum(ahead, back) <= max_gap)
        linked[here] &= cosine >= min_cosine
    return linked


@given(seed=st.integers(0, 10_000), missing=st.sampled_from([0.0, 0.2]))
@settings(max_examples=15)
def test_normals_equal_numpys(seed, missing):
    _, _, planes = random_planes(seed, missing=missing)
    expected = reference_normals(planes, CAMERA)
    assert np.allclose(plane_normals(planes, CAMERA), expected, atol=1e-6)


@given(seed=st.integers(0, 10_000), angle=st.floats(0.02, 0.3), sigmas=st.floats(1.0, 5.0))
@settings(max_examples=20)
def test_links_equal_numpys(seed, angle, sigmas):
    _, _, planes = random_planes(seed, missing=0.02)
    normals = plane_normals(planes, CAMERA)
    limits = np.float32(np.cos(angle)), np.float32(sigmas * NOISE)
    expected = reference_links(planes, normals, np.cos(angle), limits[1])
    assert np.array_equal(links(planes, normals, *limits), expected)


@given(seed=st.integers(0, 10_000), min_patch=st.integers(1, 12))
@settings(max_examples=15)
def test_patches_are_the_connected_parts_that_are_large_enough(seed, min_patch):
    linked = (np.random.default_rng(seed).random((14, 17)) < 0.55).astype(np.uint8)
    patches = label_patches(linked, min_patch)
    parts = np.zeros(linked.shape, np.int32)
    ndimage.label(linked, output=parts)
    kept = {k for k in range(1, parts.max() + 1) if (parts == k).sum() >= min_patch}
    assert patches.max() == len(kept)
    assert {int(patches[parts == k].max()) for k in kept} == set(range(1, len(kept) + 1))
    assert np.array_equal(patches > 0, np.isin(parts, list(kept)))


def test_faces_of_a_box_and_the_table_are_patches_of_their_own():
    frame, labels = solid_frame([Box(0.0, 0.6, (0.15, 0.15, 0.15), yaw=0.6)])
    image = exact_image(frame)
    planes = fit_local_planes(image, SegmentationOptions().scaled(320))
    patches = label_patches(linked_pixels(image, planes), image.area(MIN_PATCH))
    on_box = np.bincount(patches[labels == 1], minlength=patches.max() + 1)
    on_table = np.bincount(patches[labels == 0], minlength=patches.max() + 1)
    assert patches.max() == 4
    # Windows blur an outline by a pixel: no patch has more than a rim on the other side.
    assert np.count_nonzero(on_box[1:] > 20 * on_table[1:]) == 3
    assert np.count_nonzero(on_table[1:] > 20 * on_box[1:]) == 1
