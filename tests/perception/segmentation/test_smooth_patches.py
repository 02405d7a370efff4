"""Tests of smooth patches: links, normals and components equal NumPy and SciPy."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from random_planes import NOISE, random_planes
from scipy import ndimage
from synthetic_solids import Box, exact_image, solid_frame

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
    """Solve q = n·(x, y, 1) for the normals."""
    v, u = np.indices(planes.value.shape)
    x, y = planes.slope_u * camera.fx, planes.slope_v * camera.fy
    z = planes.value - x * (u - camera.cx) / camera.fx - y * (v - camera.cy) / camera.fy
    n = -np.stack([x, y, z], axis=-1)
    lengths = np.linalg.norm(n, axis=-1, keepdims=True)
    return np.where(planes.value[..., None] > 0, n / np.maximum(lengths, 1e-9), 0.0)


def reference_links(planes, normals, min_cosine, max_gap):
    """Return the links of all pixels, tested in both directions, in single precision."""
    value, known = planes.value, planes.value > 0
    linked = np.zeros(value.shape, bool)
    pixel = np.s_[:-1, :-1]
    linked[pixel] = known[pixel]
    for neighbour, slope in ((np.s_[:-1, 1:], planes.slope_u), (np.s_[1:, :-1], planes.slope_v)):
        forward_gap = np.abs(value[pixel] + slope[pixel] - value[neighbour])
        backward_gap = np.abs(value[neighbour] - slope[neighbour] - value[pixel])
        cosine = (normals[pixel] * normals[neighbour]).sum(axis=-1)
        linked[pixel] &= known[neighbour] & (np.maximum(forward_gap, backward_gap) <= max_gap)
        linked[pixel] &= cosine >= min_cosine
    return linked


@given(seed=st.integers(0, 10_000), missing=st.sampled_from([0.0, 0.2]))
@settings(max_examples=15)
def test_normals_equal_numpy(seed, missing):
    _, _, planes = random_planes(seed, missing=missing)
    expected = reference_normals(planes, CAMERA)
    assert np.allclose(plane_normals(planes, CAMERA), expected, atol=1e-6)


@given(seed=st.integers(0, 10_000), angle=st.floats(0.02, 0.3), sigmas=st.floats(1.0, 5.0))
@settings(max_examples=20)
def test_links_equal_numpy(seed, angle, sigmas):
    _, _, planes = random_planes(seed, missing=0.02)
    normals = plane_normals(planes, CAMERA)
    limits = np.float32(np.cos(angle)), np.float32(sigmas * NOISE)
    expected = reference_links(planes, normals, np.cos(angle), limits[1])
    pinhole = CAMERA.fx, CAMERA.fy, CAMERA.cx, CAMERA.cy
    assert np.array_equal(links(planes, pinhole, *limits), expected)


@given(seed=st.integers(0, 10_000), min_patch=st.integers(1, 12))
@settings(max_examples=15)
def test_patches_are_large_connected_components(seed, min_patch):
    linked = (np.random.default_rng(seed).random((14, 17)) < 0.55).astype(np.uint8)
    patches = label_patches(linked, min_patch)
    parts = np.zeros(linked.shape, np.int32)
    ndimage.label(linked, output=parts)
    kept = {k for k in range(1, parts.max() + 1) if (parts == k).sum() >= min_patch}
    assert patches.max() == len(kept)
    assert {int(patches[parts == k].max()) for k in kept} == set(range(1, len(kept) + 1))
    assert np.array_equal(patches > 0, np.isin(parts, list(kept)))


def test_box_faces_and_table_are_separate_patches():
    frame, labels = solid_frame([Box(0.0, 0.6, (0.15, 0.15, 0.15), yaw=0.6)])
    image = exact_image(frame)
    planes = fit_local_planes(image, SegmentationOptions().scaled(320))
    patches = label_patches(linked_pixels(image, planes), image.area(MIN_PATCH))
    on_box = np.bincount(patches[labels == 1], minlength=patches.max() + 1)
    on_table = np.bincount(patches[labels == 0], minlength=patches.max() + 1)
    assert patches.max() == 4
    # Windows blur an outline by one pixel: only the rim of a patch lies on the other side.
    assert np.count_nonzero(on_box[1:] > 20 * on_table[1:]) == 3
    assert np.count_nonzero(on_table[1:] > 20 * on_box[1:]) == 1
