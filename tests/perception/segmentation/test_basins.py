"""Basins: the compiled functions equal plain references, and only enclosed parts hold water."""

import heapq

import numpy as np
import pytest
from synthetic_containers import Tub, tub_frame
from synthetic_solids import exact_image

from eyehand.perception.segmentation import SupportPlane
from eyehand.perception.segmentation.basins import MIN_CHANGE, fill_basins, find_basins
from eyehand.perception.segmentation.block_heights import LOWEST, block_heights, block_tops


def flooded(tops):
    """Return the water level by a priority queue from the border inwards."""
    water = np.full(tops.shape, np.inf)
    rows, columns = tops.shape
    border = [
        (v, u) for v, u in np.ndindex(tops.shape) if v in (0, rows - 1) or u in (0, columns - 1)
    ]
    queue = []
    for place in border:
        water[place] = tops[place]
        heapq.heappush(queue, (water[place], place))
    while queue:
        level, (v, u) = heapq.heappop(queue)
        for y, x in ((v - 1, u), (v + 1, u), (v, u - 1), (v, u + 1)):
            if 0 <= y < rows and 0 <= x < columns and max(level, tops[y, x]) < water[y, x]:
                water[y, x] = max(level, tops[y, x])
                heapq.heappush(queue, (water[y, x], (y, x)))
    return water


@pytest.mark.parametrize("seed", range(5))
def test_water_level_equals_reference(seed):
    rng = np.random.default_rng(seed)
    tops = np.round(rng.uniform(0.0, 0.2, (30, 40)), 2).astype(np.float32)
    error = fill_basins(tops) - flooded(tops)
    assert error.min() >= -1e-6
    assert error.max() <= MIN_CHANGE * tops.size


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


@pytest.mark.parametrize(("tub", "count"), [(Tub(), 1), (None, 0), (Tub(0.12, 0.1), 0)])
def test_only_a_large_tub_is_a_basin(tub, count):
    frame, _, T_world_camera = tub_frame(tub)
    normal = T_world_camera.rotation.as_matrix()[2]
    plane = SupportPlane(normal, float(T_world_camera.translation[2]), 0.0005)
    image = exact_image(frame)
    assert len(find_basins(block_heights(image, plane), image, plane)) == count
