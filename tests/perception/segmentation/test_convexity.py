"""Tests of region convexity: equality with NumPy, and the sign for exact shapes."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from random_planes import image_of, random_planes
from synthetic_solids import Ball, Bowl, Box, exact_image, solid_frame

from eyehand.perception import CameraIntrinsics, SegmentationOptions
from eyehand.perception.segmentation.convexity import SAMPLES, region_convexity
from eyehand.perception.segmentation.label_pixels import pixels_by_label
from eyehand.perception.segmentation.local_planes import fit_local_planes, plane_normals

CAMERA = CameraIntrinsics(20.0, 21.0, 8.0, 7.0, 17, 14)


def reference(labels, q, planes, camera):
    """Return the convexity of every region from all pairs of its sampled points and normals."""
    convexity = np.zeros(labels.max() + 1)
    rays, normals = camera.rays(), plane_normals(planes, camera).astype(float)
    for label in range(1, len(convexity)):
        rows, columns = np.nonzero(labels == label)
        count_sampled = min(SAMPLES, rows.size)
        ranks = (2 * np.arange(count_sampled) + 1) * rows.size // (2 * max(count_sampled, 1))
        at = rows[ranks], columns[ranks]
        known = (q[at] > 0) & (planes.value[at] > 0)
        points = rays[at][known] / q[at][known, None].astype(float)
        offsets = points[:, None] - points
        normal_changes = normals[at][known][:, None] - normals[at][known]
        lengths = np.linalg.norm(offsets, axis=-1) * np.linalg.norm(normal_changes, axis=-1)
        convexity[label] = (offsets * normal_changes).sum() / max(lengths.sum(), 1e-12)
    return convexity


@given(seed=st.integers(0, 10_000), count=st.integers(0, 6))
@settings(max_examples=15)
def test_convexity_equals_sum_over_all_pairs(seed, count):
    labels, q, planes = random_planes(seed, count=count)
    result = region_convexity(labels, image_of(q, CAMERA), planes)
    assert np.allclose(result, reference(labels, q, planes, CAMERA), atol=1e-5)


@given(seed=st.integers(0, 10_000))
@settings(max_examples=10)
def test_pixels_are_sorted_by_label(seed):
    labels, _, _ = random_planes(seed)
    labels[labels == 2] = 0
    order, starts = pixels_by_label(labels, 4)
    for label in range(1, 5):
        pixels = order[starts[label] : starts[label + 1]]
        assert np.array_equal(pixels, np.flatnonzero(labels == label))


@pytest.mark.parametrize(
    ("solid", "low", "high"),
    [
        (Ball(0.0, 0.65, 0.1, 0.1), 0.95, 1.0),
        (Bowl(0.0, 0.65, 0.12, 0.12, 0.11).inside(), -1.0, -0.95),
        (Box(0.0, 0.65, (0.15, 0.15, 0.15), yaw=0.5), 0.5, 1.0),
    ],
)
def test_solids_are_convex_and_insides_concave(solid, low, high):
    frame, labels = solid_frame([solid], plates=())
    image = exact_image(frame)
    planes = fit_local_planes(image, SegmentationOptions().scaled(320))
    assert low <= region_convexity(labels, image, planes)[1] <= high


def test_flat_region_has_zero_convexity():
    labels, q, planes = random_planes(0, count=1)
    flat = planes._replace(
        value=np.ones_like(q), slope_u=np.zeros_like(q), slope_v=np.zeros_like(q)
    )
    assert region_convexity(labels, image_of(np.ones_like(q), CAMERA), flat)[1] == pytest.approx(
        0.0, abs=1e-9
    )
