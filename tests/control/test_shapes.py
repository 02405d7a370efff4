"""Collision shapes: stored values and invalid sizes."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
import pytest
from scipy.spatial.transform import RigidTransform

from eyehand.control.shapes import Box, Capsule, ConvexMesh, Cylinder, Ellipsoid, Obstacle, Sphere
from eyehand.errors import InputError

if TYPE_CHECKING:
    from collections.abc import Callable

NAN = float("nan")


def _untyped(value: object) -> Any:
    """Return the value as a caller without type checks would pass it."""
    return value


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (
            lambda: Box(_untyped((0.1, 0.0, 0.1))),
            "half_extents must be finite and >= 1e-06 m, got 0",
        ),
        (lambda: Box(_untyped((0.1, 0.1))), r"must have shape \(3,\)"),
        (lambda: Box(_untyped((0.1, NAN, 0.1))), "must be finite"),
        (lambda: Box(_untyped(("a", 1, 2))), "must be numbers"),
        (lambda: Sphere(0.0), "sphere: radius"),
        (lambda: Sphere(NAN), "sphere: radius"),
        (lambda: Sphere(_untyped("big")), "sphere: radius"),
        (lambda: Ellipsoid(_untyped((-0.1, 0.1, 0.1))), "ellipsoid: semi_axes"),
        (lambda: Cylinder(0.1, 0.0), "cylinder: half_length"),
        (lambda: Capsule(float("inf"), 0.1), "capsule: radius"),
        (lambda: Sphere(_untyped("0.1")), "radius must be finite"),
        (lambda: ConvexMesh(np.zeros((3, 3))), r"\(V, 3\) with V >= 4"),
        (lambda: ConvexMesh(np.zeros((8, 3))), "lie within"),
        (lambda: ConvexMesh(np.eye(4)[:, :3] * [1, 1, 0]), "lie in one plane"),
        (lambda: ConvexMesh(np.full((4, 3), NAN)), "must be finite"),
        (lambda: Obstacle("", Sphere(0.1), RigidTransform.identity()), "must be a text"),
        (lambda: Obstacle("o", _untyped("ball"), RigidTransform.identity()), "one of Box, Sphere"),
        (lambda: Obstacle("o", Sphere(0.1), _untyped(np.eye(4))), "must be one RigidTransform"),
        (
            lambda: Obstacle("o", Sphere(0.1), RigidTransform.from_translation([NAN, 0, 0])),
            "must be finite",
        ),
    ],
)
def test_shapes_reject_invalid_values(make: Callable[[], object], message: str) -> None:
    with pytest.raises(InputError, match=message):
        make()


def test_mesh_keeps_only_hull_vertices() -> None:
    corners = np.array(np.meshgrid([0, 1], [0, 1], [0, 1]), dtype=float).reshape(3, -1).T
    inside = np.random.default_rng(0).uniform(0.1, 0.9, (50, 3))
    mesh = ConvexMesh(np.vstack([inside, corners]))
    assert sorted(map(tuple, mesh.vertices)) == sorted(map(tuple, corners))


def test_arrays_of_shapes_are_read_only() -> None:
    sizes = np.array([0.1, 0.2, 0.3])
    box = Box(sizes)
    sizes[0] = 9.0
    assert box.half_extents[0] == 0.1
    with pytest.raises(ValueError, match="read-only"):
        box.half_extents[0] = 1.0
