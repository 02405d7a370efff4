"""Tests of growing patches: equality with a full sweep, and pixels join their plane."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from random_planes import image_of, random_planes
from scipy import ndimage

from eyehand.perception.segmentation import grow_patches as module
from eyehand.perception.segmentation.grow_patches import grow_patches, grow_rings
from eyehand.perception.segmentation.local_planes import STEP_SIGMAS, LocalPlanes

CROSS = ndimage.generate_binary_structure(2, 1)
WINDOW = 9


def reference(q, value, slope_u, slope_v, patches, allowed, max_gap, rings):
    """Sweep all pixels once per ring. Pixels beside the last ring test their eight neighbours."""
    labels = patches.copy()
    images = [image.copy() for image in (value, slope_u, slope_v)]
    last = labels > 0
    for _ in range(rings):
        border = ndimage.binary_dilation(last, CROSS) & allowed & (labels == 0)
        old_labels, old = labels.copy(), [image.copy() for image in images]
        for v, u in np.argwhere(border):
            source, gap = None, float(max_gap)
            for y, x in np.ndindex(3, 3):
                y, x = v + y - 1, u + x - 1
                inside = 0 <= y < q.shape[0] and 0 <= x < q.shape[1]
                if not inside or old_labels[y, x] == 0 or old[0][y, x] <= 0:
                    continue
                along, down = float(old[1][y, x]) * (x - u), float(old[2][y, x]) * (y - v)
                predicted = float(old[0][y, x]) - along - down
                if abs(predicted - float(q[v, u])) < gap:
                    source, gap = (y, x, predicted), abs(predicted - float(q[v, u]))
            if source is not None:
                y, x, predicted = source
                labels[v, u] = old_labels[y, x]
                images[0][v, u] = predicted
                images[1][v, u], images[2][v, u] = old[1][y, x], old[2][y, x]
        last = labels != old_labels
    return labels, *images


@given(
    seed=st.integers(0, 10_000),
    gap=st.sampled_from([0.003, 0.01, 0.05]),
    rings=st.integers(1, 5),
    unlabelled_share=st.sampled_from([0.3, 0.8]),
)
@settings(max_examples=15)
def test_grow_rings_equals_sweep_over_all_pixels(seed, gap, rings, unlabelled_share):
    labels, q, planes = random_planes(seed, missing=0.05)
    rng = np.random.default_rng(seed)
    patches = np.where(rng.random(q.shape) < unlabelled_share, 0, labels).astype(np.int32)
    allowed = (q > 0) & (rng.random(q.shape) < 0.9)
    result = grow_rings(q, planes, patches, allowed, np.array([gap], np.float32), rings)
    expected = reference(q, *planes[:3], patches, allowed, np.float32(gap), rings)
    for grown, expected_image in zip(result, expected, strict=True):
        assert np.array_equal(grown, expected_image)


@given(seed=st.integers(0, 10_000))
@settings(max_examples=15)
def test_two_passes_equal_two_calls(seed):
    labels, q, planes = random_planes(seed, missing=0.05)
    rng = np.random.default_rng(seed)
    patches = np.where(rng.random(q.shape) < 0.8, 0, labels).astype(np.int32)
    allowed = (q > 0) & (rng.random(q.shape) < 0.9)
    first = grow_rings(q, planes, patches, allowed, np.array([0.003], np.float32), 3)
    grown_planes = planes._replace(value=first[1], slope_u=first[2], slope_v=first[3])
    result = grow_rings(q, planes, patches, allowed, np.array([0.003, 0.02], np.float32), 3)
    expected = grow_rings(q, grown_planes, first[0], allowed, np.array([0.02], np.float32), 3)
    for grown, expected_image in zip(result, expected, strict=True):
        assert np.array_equal(grown, expected_image)


def test_growth_stops_at_ring_limit_and_forbidden_pixels():
    q = np.ones((5, 30), np.float32)
    flat = np.zeros_like(q)
    planes = LocalPlanes(q, flat, flat, flat)
    patches = np.zeros(q.shape, np.int32)
    patches[:, 0] = 1
    allowed = np.ones(q.shape, bool)
    grown = grow_rings(q, planes, patches, allowed, np.array([0.01], np.float32), 7)[0]
    assert np.array_equal(grown, np.tile(np.arange(30) < 8, (5, 1)))
    allowed[:, 4] = False
    grown = grow_rings(q, planes, patches, allowed, np.array([0.01], np.float32), 7)[0]
    assert np.array_equal(grown, np.tile(np.arange(30) < 4, (5, 1)))


def roof(rows=30, columns=40, crease=20, slope=0.01):
    """Return two planes that meet at a crease. Their patches start five pixels beside it."""
    u = np.indices((rows, columns))[1]
    q = (1.0 - slope * abs(u - crease)).astype(np.float32)
    truth = np.where(u < crease, 1, 2).astype(np.int32)
    patches = np.where(abs(u - crease) > 5, truth, 0).astype(np.int32)
    sloping = np.where(u < crease, np.float32(slope), np.float32(-slope))
    value = np.where(patches > 0, q, np.float32(0.0))
    planes = LocalPlanes(value, sloping * (patches > 0), np.zeros_like(q), np.zeros_like(q))
    return q, truth, patches, planes


def test_pixels_beside_crease_join_their_plane():
    q, truth, patches, planes = roof()
    allowed = np.ones(q.shape, bool)
    grown, carried = grow_patches(image_of(q), planes, patches, allowed, WINDOW)
    # The crease itself lies on both planes.
    off_crease = np.arange(40) != 20
    assert np.array_equal(grown[:, off_crease], truth[:, off_crease])
    assert np.allclose(carried.value, q, atol=1e-5)
    assert np.allclose(
        carried.slope_u[:, off_crease], np.where(truth[:, off_crease] == 1, 0.01, -0.01)
    )


def test_large_area_without_plane_becomes_patch():
    q, _, patches, planes = roof()
    q[3:12, 16:24] += 0.2
    q[20:22, 18:20] += 0.2
    grown, _ = grow_patches(image_of(q), planes, patches, np.ones(q.shape, bool), WINDOW)
    assert np.all(grown[3:12, 16:24] == 3)
    assert not grown[20:22, 18:20].any()
    assert grown.max() == 3


def test_receding_rim_is_added_in_second_pass(monkeypatch):
    q, _, patches, planes = roof()
    allowed = np.ones(q.shape, bool)
    q[:, 18:23] -= 0.02
    monkeypatch.setattr(module, "MIN_PATCH", 1000)
    assert grow_patches(image_of(q), planes, patches, allowed, WINDOW)[0][:, 18:23].all()
    monkeypatch.setattr(module, "RIM_SIGMAS", STEP_SIGMAS)
    assert not grow_patches(image_of(q), planes, patches, allowed, WINDOW)[0][:, 18:23].any()
