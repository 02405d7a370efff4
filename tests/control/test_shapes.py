"""Shapes: what they hold, and which sizes they refuse."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
import pytest
from scipy.spatial.transform import RigidTransform

from eyehand.control.shapes import (
    Box,
    Capsule,
    ConvexMesh,
    Cylinder,
    Ellipsoid,
    Obstacle,
    Sphere,
)
from eyehand.errors import InputError

if TYPE_CHECKING:
    from collections.abc import Callable

NAN = float("nan")


def _any(value: object) -> Any:
    """What a caller without types may hand in."""
    return value


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (
            lambda: Box(_any((0.1, 0.0, 0.1))),
            "half_extents must be finite and >= 1e-06 m, got 0",
        ),
        (lambda: Box(_any((0.1, 0.1))), "must be 3 numbers"),
        (lambda: Box(_any((0.1, NAN, 0.1))), "must be finite"),
        (lambda: Box(_any(("a", 1, 2))), "must be numbers"),
        (lambda: Sphere(0.0), "sphere: radius"),
        (lambda: Sphere(NAN), "sphere: radius"),
        (lambda: Sphere(_any("big")), "sphere: radius"),
        (lambda: Ellipsoid(_any((-0.1, 0.1, 0.1))), "ellipsoid: semi_axes"),
        (lambda: Cylinder(0.1, 0.0), "cylinder: half_length"),
        (lambda: Capsule(float("inf"), 0.1), "capsule: radius"),
        (lambda: Sphere(_any("0.1")), "radius must be finite"),
        (lambda: ConvexMesh(np.zeros((3, 3))), r"\(V, 3\) with V >= 4"),
        (lambda: ConvexMesh(np.zeros((8, 3))), "lie within"),
        (lambda: ConvexMesh(np.eye(4)[:, :3] * [1, 1, 0]), "lie in one plane"),
        (lambda: ConvexMesh(np.full((4, 3), NAN)), "must be finite"),
        (lambda: Obstacle("", Sphere(0.1), RigidTransform.identity()), "must be a text"),
        (lambda: Obstacle("o", _any("ball"), RigidTransform.identity()), "one of Box, Sphere"),
        (lambda: Obstacle("o", Sphere(0.1), _any(np.eye(4))), "must be one RigidTransform"),
        (
            lambda: Obstacle("o", Sphere(0.1), RigidTransform.from_translation([NAN, 0, 0])),
            "must be finite",
        ),
    ],
)
def test_what_is_no_shape_is_refused(make: Callable[[], object], message: str) -> None:
    with pytest.raises(InputError, match=message):
        make()


def test_a_mesh_keeps_only_the_corners_of_its_hull() -> None:
    corners = np.array(np.meshgrid([0, 1], [0, 1], [0, 1]), dtype=float).reshape(3, -1).T
    inside = np.random.default_rng(0).uniform(0.1, 0.9, (50, 3))
    mesh = ConvexMesh(np.vstack([inside, corners]))
    assert sorted(map(tuple, mesh.vertices)) == sorted(map(tuple, corners))


def test_arrays_of_shapes_cannot_be_written() -> None:
    sizes = np.array([0.1, 0.2, 0.3])
    box = Box(sizes)
    sizes[0] = 9.0
    assert box.half_extents[0] == 0.1
    with pytest.raises(ValueError, match="read-only"):
        box.half_extents[0] = 1.0
