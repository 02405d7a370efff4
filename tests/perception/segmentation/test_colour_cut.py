"""Cutting objects of two plain colours: straight edges only, thresholds as in a plain search."""

import numpy as np
import pytest

from eyehand.perception import CameraIntrinsics
from eyehand.perception.segmentation.colour_cut import (
    MIN_CONTRAST,
    MIN_PURITY,
    MIN_SHARE,
    STEPS,
    _first_colour,
    colour_cut,
)
from eyehand.perception.segmentation.working_image import WorkingImage, inverse

RED, BLUE = (200, 40, 40), (40, 40, 200)
V, U = np.mgrid[:60, :80]
OBJECT = np.ones((60, 80), bool)


def painted(blue):
    """Return the image of a flat red object, blue where the mask says so."""
    depth = np.full((60, 80), 0.5, np.float32)
    colour = np.where(blue[..., None], BLUE, RED).astype(np.uint8)
    camera = CameraIntrinsics(500, 500, 40, 30, 80, 60)
    return WorkingImage(depth, inverse(depth), camera, colour=colour)


def test_straight_edge_is_cut_where_it_is():
    blue = U + 0.3 * V > 45
    side = colour_cut(OBJECT, painted(blue))
    assert side is not None
    assert max(np.mean(side == blue), np.mean(side != blue)) > 0.96


@pytest.mark.parametrize("blue", [np.hypot(U - 40, V - 30) < 18, U > 1000, U < 5])
def test_print_and_plain_colours_are_not_cut(blue):
    assert colour_cut(OBJECT, painted(blue)) is None


def test_depth_alone_is_not_cut():
    assert colour_cut(OBJECT, painted(U > 40)._replace(colour=None)) is None


def plain_search(values):
    """Try one threshold after the other."""
    centred = values - values.mean(axis=0)
    along = centred @ np.linalg.eigh(centred.T @ centred)[1][:, -1]
    total = (centred**2).sum()
    highest, best = 0.0, None
    for cut in np.linspace(along.min(), along.max(), STEPS + 2)[1:-1]:
        first = along > cut
        share = first.mean()
        if MIN_SHARE <= share <= 1 - MIN_SHARE:
            gap = np.linalg.norm(centred[first].mean(axis=0) - centred[~first].mean(axis=0))
            between = len(values) * share * (1 - share) * gap**2
            if gap >= MIN_CONTRAST and between > highest:
                highest, best = between, first
    return best if highest >= MIN_PURITY * total else None


@pytest.mark.parametrize("seed", range(12))
def test_colours_are_split_as_by_plain_search(seed):
    rng = np.random.default_rng(seed)
    colours = rng.dirichlet(np.ones(3), 2)[(rng.random(400) < rng.uniform(0.05, 0.95)).astype(int)]
    values = colours + rng.normal(0, rng.choice([0.01, 0.03, 0.1]), (400, 3))
    found, expected = _first_colour(values), plain_search(values)
    assert (found is None) == (expected is None)
    if found is not None and expected is not None:
        assert np.array_equal(found, expected)
