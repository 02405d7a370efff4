"""Clouds of household meshes for the chart, with all that an image shows of them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike, NDArray

from eyehand.perception import PerceiveOptions, region_evidence

from .clouds import MESHES, FitCase
from .fit_answer import FitAnswer
from .household_meshes import read_household
from .mesh_score import mesh_ious
from .mesh_views import MeshView, PlacedMesh, mesh_views
from .score import overlap


@dataclass(frozen=True, eq=False)
class MeshTruth:
    """A mesh in the world: a `TrueSolid`. A vessel stands for its convex hull."""

    placed: PlacedMesh
    """The mesh and its pose."""

    @property
    def rotation(self) -> NDArray[np.float64]:
        """See TrueSolid."""
        return self.placed.pose.rotation.as_matrix()

    @property
    def centre(self) -> NDArray[np.float64]:
        """See TrueSolid."""
        low, high = self.placed.mesh.bounds
        return np.asarray(self.placed.pose.apply((low + high) / 2))

    def contains(self, points: ArrayLike) -> NDArray[np.bool_]:
        """See TrueSolid."""
        points = np.asarray(points, dtype=np.float64)
        mesh = self.placed.mesh
        local = self.placed.pose.inv().apply(points.reshape(-1, 3))
        inside = mesh.hull_contains(local) if mesh.kind == "vessel" else mesh.contains(local)
        return inside.reshape(points.shape[:-1])

    def support(self, directions: ArrayLike) -> NDArray[np.float64]:
        """See TrueSolid."""
        vertices = self.placed.pose.apply(self.placed.mesh.hull_vertices)
        return (np.asarray(directions, dtype=np.float64) @ vertices.T).max(axis=-1)


def mesh_cases(folders: Sequence[Path], count: int, points: int, seed: int) -> list[FitCase]:
    """Return `count` clouds of up to `points` points from views of meshes at 1 mm noise.

    The meshes take turns in a random order, with a new yaw at every turn.
    """
    meshes = read_household(folders)
    order = np.random.default_rng([seed, 43]).permutation(len(meshes))
    turns = [divmod(number, len(meshes)) for number in range(count)]
    views = [
        view
        for turn, place in turns
        for view in mesh_views([meshes[order[place]]], (_elevation(turn, place),), seed=seed + turn)
    ]
    return [mesh_case(view, number, points) for number, view in enumerate(views)]


def mesh_case(view: MeshView, seed: int, points: int) -> FitCase:
    """Return the cloud of the first object of a view, with known pixels and table."""
    pose = view.frame.T_world_camera
    table = view.table if pose is None else view.table.moved(pose.inv())
    evidence = region_evidence(
        view.frame, view.labels, 1, table, PerceiveOptions(cloud_points=points)
    )
    rng = np.random.default_rng([seed, 47])
    shuffled = evidence.points[rng.permutation(len(evidence.points))]
    return FitCase(
        group=MESHES,
        seed=seed,
        name=view.mesh.name,
        truth=MeshTruth(view.placed[0]),
        points=shuffled,
        view_origin=evidence.view_origin,
        support_plane=evidence.support_plane,
        free_space=evidence.free_space,
        margin=evidence.margin,
    )


def case_iou(case: FitCase, answer: FitAnswer) -> float:
    """Return the IoU of an answer with the true solid; no solid has 0."""
    parts = answer.usable_parts
    if not isinstance(case.truth, MeshTruth):
        return overlap(case.truth, parts, case.seed)
    if not parts:
        return 0.0
    # The samples of a mesh are computed once for all settings.
    solid, hull = mesh_ious(case.truth.placed, parts)
    return hull if case.truth.placed.mesh.kind == "vessel" else solid


def _elevation(turn: int, place: int) -> float:
    """Return the elevation of the camera, degrees: 35 or 60 in turn."""
    return 35.0 if (turn + place) % 2 == 0 else 60.0
