"""Scenes of several household meshes that stand close together on a table."""

from __future__ import annotations

import zlib
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import ConvexHull
from scipy.spatial.transform import RigidTransform

from eyehand.data_synth import look_at

from .household_meshes import HouseholdMesh
from .mesh_views import MeshView, NoiseName, PlacedMesh, render_view, rest_on_table
from .rendered_clouds import view_direction
from .resting_poses import resting_rotations

NEIGHBOURS = 3
"""Number of neighbours of the first object of a scene."""
GAPS = (0.01, 0.04)
"""Range of the distance between an object and the nearest of those before it, m."""
STEP = 0.002
"""Step of the search for a free place, m."""
MAX_REACH = 0.4
"""Maximum distance of an object's middle from that of the first one, m."""
SCENE_DISTANCE = 0.8
"""Distance from the camera to the middle of the scene, m. All objects lie in the image."""
TARGET_HEIGHT = 0.04
"""Height of the point that the camera looks at, m."""


def mesh_scenes(
    meshes: Sequence[HouseholdMesh],
    elevations: Sequence[float],
    noise: NoiseName = "1mm",
    seed: int = 0,
) -> list[MeshView]:
    """Render a scene around every mesh from each elevation, degrees.

    Each mesh has up to NEIGHBOURS others beside it, which the seed draws. All stand in the resting
    pose nearest to their file's. The objects do not touch.
    """
    found = []
    for mesh in meshes:
        for elevation in elevations:
            name = f"{mesh.key} among neighbours view {elevation}"
            own_seed = zlib.crc32(f"{seed} {name}".encode())
            rng = np.random.default_rng(own_seed)
            others = [other for other in meshes if other is not mesh]
            count = min(NEIGHBOURS, len(others))
            drawn = rng.choice(len(others), count, replace=False) if count else []
            placed = place_together([mesh, *(others[int(k)] for k in drawn)], rng)
            middle = np.mean([_footprint(item).mean(axis=0) for item in placed], axis=0)
            target = np.append(middle, TARGET_HEIGHT)
            towards = view_direction(rng.uniform(0, 2 * np.pi), np.radians(elevation))
            camera = look_at(target + SCENE_DISTANCE * towards, target)
            found.append(render_view(name, placed, camera, elevation, noise, own_seed))
    return found


def place_together(
    meshes: Sequence[HouseholdMesh], rng: np.random.Generator
) -> tuple[PlacedMesh, ...]:
    """Place meshes on a table: the first at the origin, each other one close to those before it.

    The distance of the footprints to the nearest one before lies within GAPS.
    """
    placed: list[PlacedMesh] = []
    for mesh in meshes:
        rest = resting_rotations(mesh.vertices, 1)[0]
        yaw, away, gap = rng.uniform(0, 2 * np.pi), rng.uniform(0, 2 * np.pi), rng.uniform(*GAPS)
        item = rest_on_table(mesh, rest, yaw)
        direction = np.array([np.cos(away), np.sin(away)])
        others = [_footprint(other) for other in placed]
        base = _footprint(item)
        reaches = np.arange(0.0, MAX_REACH, STEP)
        free = (
            reach
            for reach in reaches
            if all(_distance(base + reach * direction, other) >= gap for other in others)
        )
        reach = next(free, None)
        if reach is not None:
            shift = RigidTransform.from_translation(np.append(reach * direction, 0.0))
            placed.append(PlacedMesh(mesh, shift * item.pose))
    return tuple(placed)


def _footprint(item: PlacedMesh) -> NDArray[np.float64]:
    """Return the convex outline (K, 2) of an object in plan, m, counter-clockwise."""
    plan = item.pose.apply(item.mesh.hull_vertices)[:, :2]
    return plan[ConvexHull(plan).vertices]


def _distance(one: NDArray[np.float64], other: NDArray[np.float64]) -> float:
    """Return the largest gap between two convex polygons along a normal of one of them, m.

    It is negative if they overlap, and at most their distance.
    """
    return max(_gap(one, other), _gap(other, one))


def _gap(one: NDArray[np.float64], other: NDArray[np.float64]) -> float:
    edges = np.roll(one, -1, axis=0) - one
    outward = np.column_stack([edges[:, 1], -edges[:, 0]])
    outward /= np.linalg.norm(outward, axis=1, keepdims=True)
    reach = np.einsum("ij,ij->i", outward, one)
    return float(((other @ outward.T).min(axis=0) - reach).max())
