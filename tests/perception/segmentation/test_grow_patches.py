"""Growing equals a ring-by-ring sweep over all pixels, and pixels go to the plane they lie on."""

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
    """Sweep all pixels for every ring: those beside the last one look at eight neighbours."""
    labels = patches.copy()
    images = [image.copy() for image in (value, slope_u, slope_v)]
    last = labels > 0
    for _ in range(rings):
        beside = ndimage.binary_dilation(last, CROSS) & allowed & (labels == 0)
        old_labels, old = labels.copy(), [image.copy() for image in images]
        for v, u in np.argwhere(beside):
            best, gap = None, float(max_gap)
            for y, x in np.ndindex(3, 3):
                y, x = v + y - 1, u + x - 1
                inside = 0 <= y < q.shape[0] and 0 <= x < q.shape[1]
                if not inside or old_labels[y, x] == 0 or old[0][y, x] <= 0:
                    continue
                along, down = float(old[1][y, x]) * (x - u), float(old[2][y, x]) * (y - v)
                at = float(old[0][y, x]) - along - down
                if abs(at - float(q[v, u])) < gap:
                    best, gap = (y, x, at), abs(at - float(q[v, u]))
            if best is not None:
                y, x, at = best
                labels[v, u] = old_labels[y, x]
                images[0][v, u] = at
                images[1][v, u], images[2][v, u] = old[1][y, x], old[2][y, x]
        last = labels != old_labels
    return labels, *images


@given(
    seed=st.integers(0, 10_000),
    gap=st.sampled_from([0.003, 0.01, 0.05]),
    rings=st.integers(1, 5),
    free=st.sampled_from([0.3, 0.8]),
)
@settings(max_examples=15)
def test_rings_equal_a_sweep_over_all_pixels(seed, gap, rings, free):
    labels, q, planes = random_planes(seed, missing=0.05)
    rng = np.random.default_rng(seed)
    patches = np.where(rng.random(q.shape) < free, 0, labels).astype(np.int32)
    allowed = (q > 0) & (rng.random(q.shape) < 0.9)
    got = grow_rings(q, planes, patches, allowed, np.float32(gap), rings)
    expected = reference(q, *planes[:3], patches, allowed, np.float32(gap), rings)
    for mine, other in zip(got, expected, strict=True):
        assert np.array_equal(mine, other)


def test_no_more_rings_than_asked_for_and_none_over_what_is_forbidden():
    q = np.ones((5, 30), np.float32)
    flat = np.zeros_like(q)
    planes = LocalPlanes(q, flat, flat, flat)
    patches = np.zeros(q.shape, np.int32)
    patches[:, 0] = 1
    allowed = np.ones(q.shape, bool)
    grown = grow_rings(q, planes, patches, allowed, np.float32(0.01), 7)[0]
    assert np.array_equal(grown, np.tile(np.arange(30) < 8, (5, 1)))
    allowed[:, 4] = False
    grown = grow_rings(q, planes, patches, allowed, np.float32(0.01), 7)[0]
    assert np.array_equal(grown, np.tile(np.arange(30) < 4, (5, 1)))


def roof(rows=30, columns=40, crease=20, slope=0.01):
    """Two planes that meet at a crease, each known as a patch five pixels away from it."""
    u = np.indices((rows, columns))[1]
    q = (1.0 - slope * abs(u - crease)).astype(np.float32)
    truth = np.where(u < crease, 1, 2).astype(np.int32)
    patches = np.where(abs(u - crease) > 5, truth, 0).astype(np.int32)
    sloping = np.where(u < crease, np.float32(slope), np.float32(-slope))
    value = np.where(patches > 0, q, np.float32(0.0))
    planes = LocalPlanes(value, sloping * (patches > 0), np.zeros_like(q), np.zeros_like(q))
    return q, truth, patches, planes


def test_pixels_beside_a_crease_go_to_the_plane_that_they_lie_on():
    q, truth, patches, planes = roof()
    allowed = np.ones(q.shape, bool)
    grown, carried = grow_patches(image_of(q), planes, patches, allowed, WINDOW)
    # The crease itself lies on both planes.
    off = np.arange(40) != 20
    assert np.array_equal(grown[:, off], truth[:, off])
    assert np.allclose(carried.value, q, atol=1e-5)
    assert np.allclose(carried.slope_u[:, off], np.where(truth[:, off] == 1, 0.01, -0.01))


def test_what_no_plane_reaches_is_a_patch_of_its_own_if_it_is_large_enough():
    q, _, patches, planes = roof()
    q[3:12, 16:24] += 0.2
    q[20:22, 18:20] += 0.2
    grown, _ = grow_patches(image_of(q), planes, patches, np.ones(q.shape, bool), WINDOW)
    assert np.all(grown[3:12, 16:24] == 3)
    assert not grown[20:22, 18:20].any()
    assert grown.max() == 3


def test_a_rim_that_falls_off_is_taken_in_a_second_round(monkeypatch):
    q, _, patches, planes = roof()
    allowed = np.ones(q.shape, bool)
    q[:, 18:23] -= 0.02
    monkeypatch.setattr(module, "MIN_PATCH", 1000)
    assert grow_patches(image_of(q), planes, patches, allowed, WINDOW)[0][:, 18:23].all()
    monkeypatch.setattr(module, "RIM_SIGMAS", STEP_SIGMAS)
    assert not grow_patches(image_of(q), planes, patches, allowed, WINDOW)[0][:, 18:23].any()
