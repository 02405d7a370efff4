"""Rims: the compiled functions equal plain references, and rectangles of edges are found."""

import numpy as np
import pytest
from synthetic_containers import Block, Tub, tub_frame
from synthetic_solids import exact_image

from eyehand.perception import DepthFrame
from eyehand.perception.segmentation import SupportPlane
from eyehand.perception.segmentation.block_heights import LOWEST, block_heights, block_tops
from eyehand.perception.segmentation.container_walls import MIN_SIDE
from eyehand.perception.segmentation.rim_rectangles import find_rims
from eyehand.perception.segmentation.rim_votes import (
    BIN,
    LAYER,
    MIN_COVER,
    MIN_LENGTH,
    PLACE,
    cover_places,
    search_rectangle,
    side_peaks,
    vote_turns,
)


def rims_of(tub, contents=None, cut=0):
    """Return the rims in an exact frame whose readings left of column `cut` are removed."""
    frame, _, T_world_camera = tub_frame(tub, contents)
    depth = frame.depth.copy()
    depth[:, :cut] = 0.0
    frame = DepthFrame(depth, frame.intrinsics)
    normal = T_world_camera.rotation.as_matrix()[2]
    plane = SupportPlane(normal, float(T_world_camera.translation[2]), 0.0005)
    image = exact_image(frame)
    return find_rims(block_heights(image, plane), image, plane)


def test_tops_equal_reference():
    rng = np.random.default_rng(1)
    depth = rng.uniform(0.5, 1.0, (10, 14)).astype(np.float32)
    depth[rng.random(depth.shape) < 0.6] = 0.0
    depth[:4, :4] = 0.0
    u, v = rng.uniform(-0.2, 0.2, 14).astype(np.float32), rng.uniform(-1, -0.5, 10)
    tops = block_tops(depth, u, v.astype(np.float32), np.float32(1.0), 4)
    heights = np.where(depth > 0, depth * (u + v[:, None]) + 1.0, LOWEST)
    for k, m in np.ndindex(tops.shape):
        expected = heights[4 * k : 4 * k + 4, 4 * m : 4 * m + 4].max()
        assert tops[k, m] == pytest.approx(expected, abs=1e-6)


@pytest.mark.parametrize("seed", range(3))
def test_votes_equal_reference(seed):
    rng = np.random.default_rng(seed)
    plan, heights = rng.uniform(-0.3, 0.3, (200, 2)), rng.uniform(0.0, 0.1, 200)
    sizes, turns, layers = rng.uniform(0.002, 0.004, 200), np.array([0.0, 0.4, 1.1]), 12
    votes = vote_turns(plan, heights, sizes, layers, turns)
    radius = np.hypot(*plan.T).max()
    for t, turn in enumerate(turns):
        axes = np.array([[np.cos(turn), np.sin(turn)], [-np.sin(turn), np.cos(turn)]])
        for layer in range(layers):
            first = (heights / (LAYER / 2)).astype(int)
            part = (first == layer) | (first == layer + 1)
            expected = 0.0
            for values in axes @ plan[part].T:
                cells = ((values + radius) / BIN).astype(int) + 1
                lengths = np.bincount(cells, sizes[part], int(2 * radius / BIN) + 3)
                expected += ((lengths[1:] + lengths[:-1]) ** 2).sum()
            if sizes[part].sum() < MIN_LENGTH:
                expected = 0.0
            assert votes[layer, t] == pytest.approx(expected)


def test_covered_places_equal_reference():
    rng = np.random.default_rng(2)
    across, along = rng.uniform(0.0, 0.3, 100), rng.uniform(0.0, 0.4, 100)
    sides = np.array([0.05, 0.2])
    counts = cover_places(across, along, sides)
    for side, row in zip(sides, counts, strict=True):
        near = np.abs(across - side) < 1.5 * BIN
        places = np.unique((along[near] / PLACE).astype(int))
        assert row[0] == 0
        assert set(np.flatnonzero(np.diff(row))) == set(places)


def test_peaks_are_the_sides_with_the_most_edges():
    values = np.repeat([0.0, 0.1, 0.3], [30, 20, 10])
    np.testing.assert_allclose(side_peaks(values, np.full(60, 0.003)), [0.0, 0.1, 0.3], atol=1e-9)


def test_best_rectangle_equals_reference():
    rng = np.random.default_rng(3)
    xs, ys = np.sort(rng.uniform(0.0, 0.5, 4)), np.sort(rng.uniform(0.0, 0.4, 4))
    covered = [(rng.random((4, 40)) < 0.6).astype(np.int32) for _ in range(2)]
    counts = [np.pad(np.cumsum(rows, axis=1, dtype=np.int32), ((0, 0), (1, 0))) for rows in covered]
    every = (np.tile(np.arange(41, dtype=np.int32)[:, None], (4, 1, 2)),) * 2
    best = (0.0, ())
    for i, j in [(i, j) for i in range(4) for j in range(4) if xs[j] - xs[i] >= MIN_SIDE]:
        for m, n in [(m, n) for m in range(4) for n in range(4) if ys[n] - ys[m] >= MIN_SIDE]:
            across = slice(int(xs[i] / PLACE), int(xs[j] / PLACE) + 1)
            down = slice(int(ys[m] / PLACE), int(ys[n] / PLACE) + 1)
            rows = [covered[0][i, down], covered[0][j, down]]
            rows += [covered[1][m, across], covered[1][n, across]]
            places = sum(len(row) for row in rows)
            evidence = PLACE * (sum(int(row.sum()) for row in rows) - MIN_COVER * places)
            if evidence > best[0]:
                best = (evidence, (xs[i], xs[j], ys[m], ys[n]))
    bounds, evidence, *covers = search_rectangle(xs, ys, tuple(counts), every, np.zeros(2))
    assert bounds == best[1]
    assert evidence == pytest.approx(best[0])
    assert 0.0 < covers[1] < covers[0] <= 1.0


@pytest.mark.parametrize("tub", [Tub(), Tub(height=0.012), Tub(0.16, 0.12, 0.05)])
def test_rim_of_a_tub_is_found(tub):
    (rim,) = rims_of(tub)
    assert rim.height == pytest.approx(tub.height, abs=0.004)
    sides = np.linalg.norm(np.diff(rim.corners, axis=0), axis=1)[:2]
    outer = np.array([tub.width, tub.length]) + 2 * tub.thickness
    assert (np.sort(sides) < outer + 0.02).all()
    assert (np.sort(sides) > outer - 2 * tub.thickness - 0.02).all()


def test_rim_is_found_where_the_image_or_contents_interrupt_it():
    over = Block((0.0, -0.15, 0.12), (0.06, 0.1, 0.04))
    assert len(rims_of(Tub(), [over])) == 1
    assert len(rims_of(Tub(), cut=110)) == 1
    # Contents over two walls hide half of their rims.
    wide = Block((0.1, -0.08, 0.16), (0.24, 0.22, 0.08), Tub().yaw)
    assert len(rims_of(Tub(), [wide])) == 1
    full = [Block((0.0, 0.0, 0.065), (0.3, 0.2, 0.13), Tub().yaw)]
    assert len(rims_of(Tub(), full)) == 1


@pytest.mark.parametrize("tub", [None, Tub(0.12, 0.1), Tub(height=0.004)])
def test_no_rim_without_a_large_tub(tub):
    assert not rims_of(tub)


def test_box_top_is_no_rim():
    assert not rims_of(None, [Block((0.0, 0.0, 0.05), (0.3, 0.2, 0.1), 0.4)])
