"""Distances and distance rows against finite differences, NumPy, exact values and coal."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import RigidTransform, Rotation

from eyehand.control.capsule_in_box import axis_in_box
from eyehand.control.collision_world import CollisionWorld
from eyehand.control.options import CollisionOptions
from eyehand.control.robot_model import RobotModel
from eyehand.control.shapes import (
    Box,
    Capsule,
    ConvexMesh,
    Cylinder,
    Ellipsoid,
    Obstacle,
    Shape,
    Sphere,
)

from .proximity_reference import proximity_reference

SEED = 11
SHAPES: dict[str, Shape] = {
    "box": Box(np.array([0.04, 0.07, 0.1])),
    "sphere": Sphere(0.06),
    "ellipsoid": Ellipsoid(np.array([0.05, 0.08, 0.11])),
    "cylinder": Cylinder(0.05, 0.09),
    "capsule": Capsule(0.04, 0.09),
    "mesh": ConvexMesh(np.random.default_rng(SEED).normal(size=(14, 3)) * 0.06),
}
GEOMS = {
    "box": 'type="box" size=".03 .05 .08"',
    "sphere": 'size=".05"',
    "ellipsoid": 'type="ellipsoid" size=".03 .06 .09"',
    "cylinder": 'type="cylinder" size=".04 .07"',
    "capsule": 'type="capsule" size=".03 .08"',
    "mesh": 'type="mesh" mesh="part"',
}
VERTICES = "0 0 0 .11 0 0 0 .1 0 0 0 .12 .07 .08 .09 -.02 .05 .04"
FLOATING_PART = """
<mujoco><compiler angle="radian"/><asset><mesh name="part" vertex="{vertices}"/></asset>
<worldbody><body name="flyer" {pose}>
<joint name="x" type="slide" axis="1 0 0"/><joint name="y" type="slide" axis="0 1 0"/>
<joint name="z" type="slide" axis="0 0 1"/><joint name="a" axis="1 0 0"/>
<joint name="b" axis="0 1 0" pos="0 .05 0"/><joint name="c" axis="0 0 1" pos=".1 0 0"/>
<geom name="part" {geom}/></body>{more}</worldbody></mujoco>
"""
"""A part that slides along three axes and turns about three axes."""
CURVED = {"ellipsoid", "cylinder"}
"""Shapes for which MuJoCo iterates: distances to 1e-11 m, normals to the square root of that."""


def _floating_part(kind: str, more: str = "") -> RobotModel:
    text = FLOATING_PART.format(geom=GEOMS[kind], vertices=VERTICES, pose="", more=more)
    return RobotModel.load(text, "flyer", home=np.zeros(12 if more else 6))


def _pose(rng: np.random.Generator, size: float) -> RigidTransform:
    return RigidTransform.from_components(rng.normal(size=3) * size, Rotation.random(rng=rng))


def _slope(world: CollisionWorld, q: np.ndarray, column: int, step: float) -> float:
    move = step * np.eye(len(q))[column]
    ahead, behind = (world.proximity(q + sign * move).distance[0] for sign in (1.0, -1.0))
    return float(ahead - behind) / (2.0 * step)


def _check_rows(
    world: CollisionWorld, postures: np.ndarray, step: float = 1e-5, tolerance: float = 1e-6
) -> tuple[int, int]:
    """Compare rows with finite differences where two step sizes agree.

    Return the number of compared configurations inside and outside.
    """
    inside = outside = 0
    for q in postures:
        near = world.proximity(q)
        if abs(near.distance[0]) < 1e-3:
            continue
        slopes = np.array(
            [[_slope(world, q, k, h) for k in range(len(q))] for h in (2 * step, step)]
        )
        smooth = np.abs(slopes[0] - slopes[1]) < 0.1 * step
        if not smooth.all():
            continue
        # Richardson extrapolation: the error of a central difference is quadratic in its step.
        expected = (4.0 * slopes[1] - slopes[0]) / 3.0
        np.testing.assert_allclose(near.rows[0], expected, atol=tolerance)
        inside += int(near.distance[0] < 0.0)
        outside += int(near.distance[0] > 0.0)
    return inside, outside


@pytest.mark.parametrize("other", SHAPES)
@pytest.mark.parametrize("kind", GEOMS)
def test_rows_are_derivative_of_distance(kind: str, other: str) -> None:
    rng = np.random.default_rng(SEED)
    world = CollisionWorld(_floating_part(kind), options=CollisionOptions(cut_off=1.0))
    world.add(Obstacle("o", SHAPES[other], _pose(rng, 0.02)))
    spread = np.repeat([0.09, 1.0], 3)
    accuracy = (1e-4, 3e-5) if CURVED & {kind, other} else (1e-5, 1e-6)
    inside, outside = _check_rows(world, rng.normal(size=(24, 6)) * spread, *accuracy)
    assert inside >= 3
    assert outside >= 3


@pytest.mark.parametrize(
    ("kind", "other"), [("box", "box"), ("capsule", "box"), ("mesh", "capsule")]
)
def test_rows_of_two_moving_parts_are_derivative_of_distance(kind: str, other: str) -> None:
    joints = "".join(
        f'<joint name="{name}2" {kind_of_joint} axis="{axis}"/>'
        for name, kind_of_joint, axis in [
            ("x", 'type="slide"', "1 0 0"),
            ("y", 'type="slide"', "0 1 0"),
            ("z", 'type="slide"', "0 0 1"),
            ("a", "", "1 0 0"),
            ("b", "", "0 1 0"),
            ("c", "", "0 0 1"),
        ]
    )
    more = f'<body name="second" pos=".3 0 0">{joints}<geom name="o" {GEOMS[other]}/></body>'
    world = CollisionWorld(_floating_part(kind, more), options=CollisionOptions(cut_off=1.0))
    rng = np.random.default_rng(SEED)
    postures = rng.normal(size=(24, 12)) * np.tile(np.repeat([0.08, 1.0], 3), 2)
    postures[:, 6] -= 0.3
    assert world.pair_names == (("part", "o"),)
    inside, outside = _check_rows(world, postures)
    assert inside >= 2
    assert outside >= 2


def test_rows_and_distance_to_plane() -> None:
    floor = '<geom name="floor" type="plane" size="1 1 .1" pos="0 0 -.4"/>'
    text = FLOATING_PART.format(geom=GEOMS["capsule"], vertices=VERTICES, pose="", more=floor)
    world = CollisionWorld(RobotModel.load(text, "flyer"), options=CollisionOptions(cut_off=1.0))
    near = world.proximity(np.zeros(6))
    np.testing.assert_allclose(near.distance, 0.4 - 0.03 - 0.08, atol=1e-12)
    np.testing.assert_allclose(near.normal, [[0, 0, 1]], atol=1e-12)
    postures = np.random.default_rng(SEED).normal(size=(12, 6)) * np.repeat([0.2, 1.0], 3)
    assert sum(_check_rows(world, postures)) >= 8


@pytest.mark.parametrize("kind", GEOMS)
def test_kernel_equals_numpy_reference(kind: str) -> None:
    rng = np.random.default_rng(SEED)
    obstacles = [Obstacle(name, shape, _pose(rng, 0.15)) for name, shape in SHAPES.items()]
    world = CollisionWorld(_floating_part(kind), obstacles)
    world.move("box", _pose(rng, 0.1), rng.normal(size=6))
    world.attach("held", Capsule(0.02, 0.05), RigidTransform.from_translation([0, 0, 0.2]))
    for q in rng.normal(size=(12, 6)) * np.repeat([0.1, 1.0], 3):
        near = world.proximity(q)
        index, *expected = proximity_reference(world.tables, q)
        assert near.names == tuple(world.tables.names[pair] for pair in index)
        fields = ("distance", "normal", "on_robot", "on_other", "rows", "drift")
        for field, values in zip(fields, expected, strict=True):
            np.testing.assert_allclose(getattr(near, field), values, atol=1e-10, err_msg=field)


@pytest.mark.parametrize("other", SHAPES)
@pytest.mark.parametrize("kind", GEOMS)
def test_normal_points_and_distance_are_consistent(kind: str, other: str) -> None:
    rng = np.random.default_rng(SEED)
    world = CollisionWorld(_floating_part(kind), options=CollisionOptions(cut_off=1.0))
    world.add(Obstacle("o", SHAPES[other], _pose(rng, 0.02)))
    for q in rng.normal(size=(30, 6)) * np.repeat([0.08, 1.0], 3):
        near = world.proximity(q)
        np.testing.assert_allclose(np.linalg.norm(near.normal, axis=1), 1.0, atol=1e-9)
        np.testing.assert_allclose(
            near.on_robot - near.on_other, near.distance[:, None] * near.normal, atol=1e-7
        )
        if near.distance[0] < -1e-3:
            # Move the part out by its depth along the normal. The parts then just touch.
            moved = q.copy()
            moved[:3] -= near.distance[0] * near.normal[0]
            # Other directions may lead out by a shorter path, so only contact is tested.
            assert abs(world.proximity(moved).distance[0]) < 1e-6


@pytest.mark.parametrize(
    ("kind", "other", "reach"),
    [
        ("sphere", Sphere(0.06), 0.11),
        ("sphere", Box(np.array([0.04, 0.05, 0.06])), 0.11),
        ("box", Box(np.array([0.04, 0.05, 0.06])), 0.14),
        ("capsule", Cylinder(0.04, 0.05), 0.16),
        ("cylinder", Ellipsoid(np.array([0.04, 0.05, 0.06])), 0.13),
        ("ellipsoid", Ellipsoid(np.array([0.04, 0.05, 0.06])), 0.15),
    ],
)
@pytest.mark.parametrize("off", [0.0, 1e-13, -1e-13, 1e-9, -1e-9, 1e-7, -1e-7])
def test_touching_parts_have_defined_normal(
    kind: str, other: Shape, reach: float, off: float
) -> None:
    world = CollisionWorld(_floating_part(kind))
    world.add(Obstacle("o", other, RigidTransform.identity()))
    q = np.array([0.0, 0.0, reach + off, 0.0, 0.0, 0.0])
    near = world.proximity(q)
    np.testing.assert_allclose(near.distance, off, atol=1e-10)
    np.testing.assert_allclose(near.normal, [[0.0, 0.0, 1.0]], atol=1e-3)
    np.testing.assert_allclose(near.rows[0, :3], [0.0, 0.0, 1.0], atol=1e-3)
    assert np.all(np.isfinite(near.rows))


@pytest.mark.parametrize("kind", GEOMS)
@pytest.mark.parametrize("other", SHAPES)
def test_coincident_parts_have_finite_rows(kind: str, other: str) -> None:
    world = CollisionWorld(_floating_part(kind))
    world.add(Obstacle("o", SHAPES[other], RigidTransform.identity()))
    near = world.proximity(np.zeros(6))
    assert near.distance[0] < 0.0
    assert np.all(np.isfinite(near.rows))
    np.testing.assert_allclose(np.linalg.norm(near.normal), 1.0, atol=1e-9)


def _depth_by_search(centre: np.ndarray, half_axis: np.ndarray, half_extents: np.ndarray) -> float:
    """Return the largest separation over many directions. It is never above the true one."""
    rng = np.random.default_rng(SEED)
    directions = rng.normal(size=(4000, 3))
    edges = np.cross(np.eye(3), half_axis)
    directions = np.vstack([directions, np.eye(3), edges, -edges, -np.eye(3)])
    directions = directions[np.linalg.norm(directions, axis=1) > 1e-9]
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    return float(
        np.max(
            directions @ centre - np.abs(directions) @ half_extents - np.abs(directions @ half_axis)
        )
    )


numbers = st.floats(-1.0, 1.0)
vectors = st.tuples(numbers, numbers, numbers)
sizes = st.tuples(*[st.floats(0.01, 1.0)] * 3)


@settings(max_examples=200, deadline=None)
@given(vectors, vectors, sizes, st.floats(-1.0, 1.0))
@example((0.67244, 0.0, 0.0), (0.0, 0.1640625, 1.0), (0.67244, 1.0, 0.5), 0.0)
def test_axis_in_box_returns_minimum_translation_distance(
    inside: tuple, half_axis: tuple, half_extents: tuple, fraction: float
) -> None:
    if np.linalg.norm(half_axis) < 1e-3:
        return
    extents = np.array(half_extents)
    # Select the centre such that one point of the segment is inside the box.
    centre = np.array(inside) * extents - fraction * np.array(half_axis)
    separation, where, normal = axis_in_box(
        tuple(centre.tolist()), tuple(map(float, half_axis)), tuple(extents.tolist())
    )
    assert separation <= 1e-12
    if separation > 0.0:  # Separated by rounding: the other results are undefined.
        return
    expected = _depth_by_search(centre, np.array(half_axis), extents)
    np.testing.assert_allclose(separation, expected, atol=1e-9)
    np.testing.assert_allclose(np.linalg.norm(normal), 1.0, atol=1e-9)
    assert -1.0 <= where <= 1.0
    # The projection of the deepest point must lie on the surface of the box.
    deepest = centre + where * np.array(half_axis)
    on_box = np.abs(deepest - separation * np.array(normal))
    np.testing.assert_allclose(np.max(on_box / extents), 1.0, atol=1e-6)


def test_capsule_through_plate_has_depth_across_plate() -> None:
    world = CollisionWorld(_floating_part("capsule"))
    world.add(Obstacle("plate", Box(np.array([0.5, 0.5, 0.005])), RigidTransform.identity()))
    near = world.proximity(np.array([0.1, 0.0, 0.05, 0.1, 0.0, 0.0]))
    out = world.proximity(np.array([0.1, 0.0, 0.05, 0.1, 0.0, 0.0]) - np.eye(6)[2] * near.distance)
    assert near.distance[0] < -0.03
    assert near.normal[0, 2] > 0.9
    assert abs(out.distance[0]) < 0.01


def test_sphere_in_cylinder_has_minimum_depth() -> None:
    world = CollisionWorld(_floating_part("sphere"))
    world.add(Obstacle("o", Cylinder(0.05, 0.09), RigidTransform.identity()))
    for centre in np.random.default_rng(SEED).uniform(-1, 1, (50, 3)) * [0.03, 0.03, 0.08]:
        near = world.proximity(np.concatenate([centre, np.zeros(3)]))
        depth = min(0.05 - np.hypot(*centre[:2]), 0.09 - abs(centre[2])) + 0.05
        np.testing.assert_allclose(near.distance, -depth, atol=1e-12)


def test_distances_equal_coal() -> None:
    coal = pytest.importorskip("coal")
    kinds = {
        "box": lambda: coal.Box(0.06, 0.10, 0.16),
        "sphere": lambda: coal.Sphere(0.05),
        "ellipsoid": lambda: coal.Ellipsoid(0.03, 0.06, 0.09),
        "cylinder": lambda: coal.Cylinder(0.04, 0.14),
        "capsule": lambda: coal.Capsule(0.03, 0.16),
    }
    others = {
        "box": coal.Box(0.08, 0.14, 0.2),
        "sphere": coal.Sphere(0.06),
        "ellipsoid": coal.Ellipsoid(0.05, 0.08, 0.11),
        "cylinder": coal.Cylinder(0.05, 0.18),
        "capsule": coal.Capsule(0.04, 0.18),
    }
    rng = np.random.default_rng(SEED)
    request = coal.DistanceRequest(True, True)
    for kind, make in kinds.items():
        robot = _floating_part(kind)
        world = CollisionWorld(robot, options=CollisionOptions(cut_off=1.0))
        for other, shape in others.items():
            pose = _pose(rng, 0.05)
            world.add(Obstacle(other, SHAPES[other], pose))
            for q in rng.normal(size=(20, 6)) * np.repeat([0.1, 1.0], 3):
                state = robot.at(q)
                result = coal.DistanceResult()
                one = coal.Transform3s(state.rotation, state.position)
                two = coal.Transform3s(pose.rotation.as_matrix(), pose.translation)
                expected = coal.distance(make(), one, shape, two, request, result)
                near = world.proximity(q)
                if expected < 0.0 and {kind, other} == {"sphere", "cylinder"}:
                    # Coal is up to 27 mm too deep here. The closed form is tested above.
                    continue
                # The iterations of coal stop at 1e-6.
                np.testing.assert_allclose(near.distance[0], expected, atol=2e-6)
            world.remove(other)
