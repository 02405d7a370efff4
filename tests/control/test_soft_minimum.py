"""Sphere covers of parts, and the soft distance with a continuous gradient."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import RigidTransform, Rotation

from eyehand.control.collision_options import CollisionOptions, CoverOptions
from eyehand.control.collision_world import CollisionWorld
from eyehand.control.robot_model import RobotModel
from eyehand.control.shapes import Box, Capsule, Cylinder, Obstacle, Sphere
from eyehand.control.sphere_cover import cover_box, cover_capsule, cover_geom

from .soft_minimum import soft_minimum

SEED = 7
HALF = np.array([0.05, 0.04, 0.01])
HAND = """
<mujoco><compiler angle="radian"/><asset><mesh name="part" vertex="{vertices}"/></asset>
<worldbody><body name="hand">
<joint name="x" type="slide" axis="1 0 0"/><joint name="y" type="slide" axis="0 1 0"/>
<joint name="z" type="slide" axis="0 0 1"/><joint name="a" axis="1 0 0"/>
<joint name="b" axis="0 1 0"/><joint name="c" axis="0 0 1"/><geom name="hand" {geom}/>
</body></worldbody></mujoco>
"""
GEOMS = {
    "box": f'type="box" size="{HALF[0]} {HALF[1]} {HALF[2]}"',
    "capsule": 'type="capsule" size=".03 .08" euler="0 1.5707963 0"',
    "cylinder": 'type="cylinder" size=".04 .05"',
    "mesh": 'type="mesh" mesh="part"',
}
VERTICES = "0 0 0 .11 0 0 0 .1 0 0 0 .12 .07 .08 .09 -.02 .05 .04"
ROTATION = np.deg2rad(0.002)
COVER = CollisionOptions(cut_off=1.0, cover=CoverOptions())
EXACT = CollisionOptions(cut_off=1.0)


def _hand(kind: str) -> RobotModel:
    return RobotModel.load(HAND.format(geom=GEOMS[kind], vertices=VERTICES), "hand")


def _rows_across_parallel(kind: str, height: float, options: CollisionOptions) -> np.ndarray:
    """Return the rows on both sides of the configuration with the hand parallel to a table."""
    table = Obstacle("table", Box(np.array([0.5, 0.5, 0.05])), RigidTransform.identity())
    world = CollisionWorld(_hand(kind), [table], options=options)
    postures = [np.array([0, 0, height, 0, turn, 0]) for turn in (-ROTATION / 2, ROTATION / 2)]
    return np.array([world.proximity(q).rows[0] for q in postures])


@pytest.mark.parametrize(("kind", "half_length"), [("box", 0.05), ("capsule", 0.08)])
@pytest.mark.parametrize("gap", [0.002, 0.03])
def test_gradient_of_soft_distance_is_continuous_at_parallel_faces(
    kind: str, half_length: float, gap: float
) -> None:
    height = 0.05 + gap + (HALF[2] if kind == "box" else 0.03)
    exact = _rows_across_parallel(kind, height, EXACT)
    smooth = _rows_across_parallel(kind, height, COVER)
    # The closest point jumps from one end of the hand to the other.
    np.testing.assert_allclose(np.abs(exact[1] - exact[0]).max(), 2 * half_length, rtol=1e-3)
    assert np.abs(smooth[1] - smooth[0]).max() < 0.01 * half_length
    assert np.linalg.norm(smooth[1] - smooth[0]) < 0.01 * np.linalg.norm(smooth[0])


@pytest.mark.parametrize("kind", GEOMS)
def test_soft_distance_is_tight_lower_bound(kind: str) -> None:
    rng = np.random.default_rng(SEED)
    robot = _hand(kind)
    shapes = [
        Box(np.array([0.05, 0.1, 0.07])),
        Sphere(0.06),
        Capsule(0.03, 0.1),
        Cylinder(0.1, 0.05),
    ]
    for shape in shapes:
        pose = RigidTransform.from_components(rng.normal(size=3) * 0.02, Rotation.random(rng=rng))
        obstacles = [Obstacle("o", shape, pose)]
        true, soft = (CollisionWorld(robot, obstacles, options=o) for o in (EXACT, COVER))
        for q in rng.normal(size=(40, 6)) * np.repeat([0.1, 1.0], 3):
            distance = true.proximity(q).distance[0]
            soft_distance = soft.proximity(q).distance[0]
            if distance <= 0.0:
                # Inside, the depth of a single sphere may be smaller than that of the part.
                assert soft_distance < 0.0
                continue
            assert soft_distance <= distance + 1e-9
            if kind in ("box", "capsule"):
                # The bound is the overhang of the spheres plus log(64) / 2000.
                assert soft_distance >= distance - 0.008 - 0.0021


@pytest.mark.parametrize("kind", GEOMS)
def test_soft_rows_are_derivative_of_soft_distance(kind: str) -> None:
    rng = np.random.default_rng(SEED)
    obstacles = [Obstacle("o", Box(np.array([0.05, 0.1, 0.07])), RigidTransform.identity())]
    world = CollisionWorld(_hand(kind), obstacles, options=COVER)
    step = 1e-6
    checked = 0
    for q in rng.normal(size=(30, 6)) * np.repeat([0.15, 1.0], 3):
        near = world.proximity(q)
        if near.distance[0] < 0.0:
            continue
        slopes = []
        for move in step * np.eye(6):
            ends = [world.proximity(q + sign * move).distance[0] for sign in (1, -1)]
            slopes.append((ends[0] - ends[1]) / (2 * step))
        np.testing.assert_allclose(near.rows[0], slopes, atol=2e-5)
        checked += 1
    assert checked >= 8


sizes = st.floats(1e-3, 0.3)


@settings(max_examples=60, deadline=None)
@given(st.tuples(sizes, sizes, sizes), st.integers(1, 100), st.floats(1e-3, 0.05))
def test_spheres_contain_box(half: tuple, max_spheres: int, overhang: float) -> None:
    extents = np.array(half)
    spheres = cover_box(extents, CoverOptions(overhang=overhang, max_spheres=max_spheres))
    assert 1 <= len(spheres) <= max_spheres
    points = np.random.default_rng(SEED).uniform(-1, 1, (300, 3))
    points[:100] = np.sign(points[:100])
    points[100:200, 0] = np.sign(points[100:200, 0])
    _check_inside(points * extents, spheres)


@settings(max_examples=60, deadline=None)
@given(sizes, sizes, st.integers(1, 60), st.floats(1e-3, 0.05))
def test_spheres_contain_capsule(
    radius: float, half_length: float, max_spheres: int, overhang: float
) -> None:
    spheres = cover_capsule(
        radius, half_length, CoverOptions(overhang=overhang, max_spheres=max_spheres)
    )
    assert 1 <= len(spheres) <= max_spheres
    rng = np.random.default_rng(SEED)
    directions = rng.normal(size=(300, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    points = radius * directions
    points[:, 2] += half_length * rng.uniform(-1, 1, 300)
    points[:150, 2] = radius * directions[:150, 2] + np.sign(directions[:150, 2]) * half_length
    _check_inside(points, spheres)
    if len(spheres) < max_spheres:
        assert spheres[0, 3] <= radius + overhang + 1e-9


def _check_inside(points: np.ndarray, spheres: np.ndarray) -> None:
    gaps = np.linalg.norm(points[:, None] - spheres[None, :, :3], axis=2) - spheres[:, 3]
    assert gaps.min(axis=1).max() <= 1e-12


@pytest.mark.parametrize("kind", ["cylinder", "mesh"])
def test_spheres_contain_cylinder_and_mesh(kind: str) -> None:
    model = _hand(kind).model
    spheres = cover_geom(model, 0, CoverOptions())
    if kind == "mesh":
        points = model.mesh_vert
    else:
        angles = np.linspace(0, 2 * np.pi, 50)
        rim = np.column_stack([0.04 * np.cos(angles), 0.04 * np.sin(angles), np.full(50, 0.05)])
        points = np.vstack([rim, rim * [1, 1, -1], rim * [1, 1, 0], rim * [0.5, 0.5, 1]])
    _check_inside(np.asarray(points, dtype=np.float64), spheres)


def test_ellipsoid_has_no_sphere_cover() -> None:
    text = HAND.format(geom='type="ellipsoid" size=".1 .2 .3"', vertices=VERTICES)
    assert len(cover_geom(RobotModel.load(text, "hand").model, 0, CoverOptions())) == 0


@given(st.lists(st.floats(-10, 10), min_size=1, max_size=40), st.floats(0.1, 1e5))
def test_soft_minimum_is_bounded_below_minimum(distances: list, k: float) -> None:
    value, weights = soft_minimum(np.array(distances), k)
    minimum = min(distances)
    assert minimum - np.log(len(distances)) / k - 1e-9 <= value <= minimum + 1e-9
    assert weights.sum() == pytest.approx(1.0)
    assert np.all(weights >= 0.0)
