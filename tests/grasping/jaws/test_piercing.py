"""Safe grasps: no reading or wall reaches into the hand."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from jaw_scenes import box, can, scene_of

from eyehand.grasping import load_hand, plan_grasps
from eyehand.perception import Container, Wall, perceive, read_frame

PANDA = load_hand("panda")
FRAMES = Path(__file__).parents[4] / "shared" / "data" / "real_points"
DEPTH, MAX_READINGS = 0.003, 4
"""Depth inside the hand, m, and number of readings that may lie deeper. Single ones are noise."""


def _inside(points, grasp):
    """Return the number of points (N, 3) deeper inside the hand than `DEPTH`."""
    local = grasp.T_scene_tcp.inv().apply(points)
    boxes = np.concatenate([PANDA.jaw_boxes(grasp.width), PANDA.fixed_boxes()])
    depth = [np.minimum(local - low, high - local).min(axis=1) for low, high in boxes]
    return np.count_nonzero(np.max(depth, axis=0) > DEPTH)


def _wall_points(wall):
    u, v = (part.reshape(-1, 1) for part in np.meshgrid(np.linspace(0, 1, 120), [*np.arange(60)]))
    corners = wall.corners
    v = v / 59
    return corners[0] + u * (corners[1] - corners[0]) + v * (corners[3] - corners[0])


def _check(scene):
    grasps = plan_grasps(scene, PANDA)
    safe = [grasp for grasp in grasps if grasp.safe]
    walls = [_wall_points(wall) for one in scene.containers for wall in one.walls]
    for grasp in safe:
        for item in scene.objects:
            assert _inside(item.points, grasp) <= MAX_READINGS
        for points in walls:
            assert _inside(points, grasp) <= MAX_READINGS
    return safe


def _bin(half, height):
    """Return a square bin around the origin."""
    ring = half * np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])
    walls = []
    for first, second in zip(ring, np.roll(ring, -1, axis=0), strict=True):
        corners = [[*first, 0], [*second, 0], [*second, height], [*first, height]]
        walls.append(Wall(np.array(corners), 0.01))
    support = scene_of().support
    assert support is not None
    return Container(support, tuple(walls), height)


@pytest.mark.parametrize("seed", range(6))
def test_bin_of_solids(seed):
    rng = np.random.default_rng(seed)
    places = [(x, y) for x in (-0.11, 0.0, 0.11) for y in (-0.11, 0.0, 0.11)]
    items = []
    for label, place in enumerate(places, 1):
        at = np.array(place) + rng.uniform(-0.02, 0.02, 2)
        if rng.random() < 0.5:
            items.append(can(rng.uniform(0.015, 0.03), rng.uniform(0.04, 0.1), at, label))
        else:
            items.append(box(rng.uniform(0.03, 0.07, 3), at, rng.uniform(0, np.pi), label))
    scene = replace(scene_of(*items), containers=(_bin(0.17, 0.12),))
    _check(scene)


def test_wall_beside_a_can_allows_the_other_closing_direction_only():
    scene = replace(scene_of(can(0.02, 0.08, (0.0, 0.12))), containers=(_bin(0.145, 0.15),))
    safe = _check(scene)
    assert safe
    assert all(abs(grasp.closing[0]) > 0.5 for grasp in safe if grasp.approach[2] < -0.9)


@pytest.mark.skipif(not FRAMES.is_dir(), reason=f"{FRAMES} does not exist")
@pytest.mark.parametrize("name", ["gq_phoxi_dexnet_1", "gq_phoxi_fcgqcnn_0", "gq_ps_clutter_0"])
def test_real_frames(name):
    assert _check(perceive(read_frame(FRAMES / name / "depth.png")))
