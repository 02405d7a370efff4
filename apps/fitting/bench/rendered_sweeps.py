"""Stress sweeps over images of solids on a table: thin, hollow, bent, branching, hidden."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.spatial.transform import RigidTransform, Rotation

from eyehand.data_synth import ViewOptions, look_at
from eyehand.data_synth.scenes import camera_intrinsics, staged_solids
from eyehand.perception import Superquadric, region_evidence
from eyehand.perception.superquadric import mesh

from ...bench import Sweep, Trial
from ...mesh_file import join_meshes
from .compound_solids import CompoundSolid
from .household_meshes import HouseholdMesh
from .mesh_views import DISTANCE, PlacedMesh, render_view
from .rendered_clouds import view_direction
from .stress_trial import RIGHT, FitCallable, try_fit, try_stated_doubt
from .stress_views import CloudView

Mesh = tuple[NDArray[np.float64], NDArray[np.int64]]


MM = 1e-3
EDGE = 0.05
"""Exponent of sharp edges."""
ELEVATION = np.radians(45.0)
"""Elevation of the camera, rad."""
BOX_HALF = (0.025, 0.06)
"""Range of the half sides of boxes, m."""
RESOLUTION = 64
"""Facets around a solid."""
MIN_PIXELS = 300
"""Minimum number of pixels of an object that is partly hidden."""
BEND_STEPS = 24
"""Straight pieces of a bent tube. 180° over 220 mm are exact to 0.1 mm."""
BEND_LENGTH, BEND_RADIUS = 0.22, 0.014
"""Length along the middle and radius of a bent tube, m."""
ARM_LENGTH, ARM_HALF = (0.06, 0.09), 0.011
"""Range of the length of an arm, and half its width and height, m."""


def rendered_sweeps() -> tuple[Sweep[FitCallable], ...]:
    """Return the sweeps of thin, hollow, bent and branching solids, of views and of occlusion."""
    accurate = f"IoU of {100 * RIGHT:.0f} % or more"
    stated = f"{accurate}, or a refusal, or a stated doubt"
    walls, turns = (100, 50, 30, 20, 10, 5), (0, 20, 40, 60, 90, 120, 150, 180)
    tilts, hidden = (45, 30, 20, 15, 10, 5, 2, 0), (0, 15, 30, 45, 60, 75, 90)
    return (
        Sweep(
            *("thin", "thickness of a plate on a table", "mm"),
            (30, 20, 15, 10, 7, 5, 3, 2), 7, _thin, accurate,
        ),
        Sweep(
            *("hollow", "wall of a cup over its radius, against the hull", "%"),
            walls, 50, _hollow, accurate,
        ),
        Sweep(*("bent", "bend of a tube on a table", "°"), turns, 0, _bent, stated),
        Sweep(
            *("branching", "arms of a star on a table", ""),
            (1, 2, 3, 4, 5, 6), 6, _branching, stated,
        ),
        Sweep(
            *("frontal", "elevation of a view on the front of a box on a table", "°"),
            tilts, 0, _frontal, stated,
        ),
        Sweep(
            *("hidden", "share of a box that an object in front hides", "%"),
            hidden, 15, _hidden, stated,
        ),
    )  # fmt: skip


def _thin(thickness_mm: float, seed: int, method: FitCallable) -> Trial:
    rng = _rng(seed, 1)
    a, b = rng.uniform(0.035, 0.07, 2)
    return try_fit(method, _table_view(_standing_box([a, b, thickness_mm * MM / 2]), rng), seed)


def _hollow(wall_pct: float, seed: int, method: FitCallable) -> Trial:
    rng = _rng(seed, 2)
    radius, height = rng.uniform(0.03, 0.05), rng.uniform(0.05, 0.1)
    pose = RigidTransform.from_translation([0.0, 0.0, height / 2])
    truth = Superquadric(np.array([radius, radius, height / 2]), (EDGE, 1.0), pose)
    if wall_pct >= 100:
        return try_fit(method, _table_view(truth, rng), seed)
    (turned,) = staged_solids.cup(radius, radius, height, wall_pct / 100 * radius).parts
    hollow = turned.mesh() if isinstance(turned, staged_solids.Turned) else None
    return try_fit(method, _table_view(truth, rng, surface=hollow), seed)


def _bent(bend_deg: float, seed: int, method: FitCallable) -> Trial:
    path = _arc(np.radians(bend_deg))
    pieces = tuple(_bar(a, b, BEND_RADIUS) for a, b in pairwise(path))
    truth = CompoundSolid(pieces, RigidTransform.identity())
    return try_stated_doubt(method, _table_view(truth, _rng(seed, 3)), seed)


def _branching(arms: float, seed: int, method: FitCallable) -> Trial:
    rng = _rng(seed, 4)
    parts = []
    for number in range(int(arms)):
        half = rng.uniform(*ARM_LENGTH) / 2
        turn = Rotation.from_euler("z", 2 * np.pi * number / arms)
        parts.append(_box([half, ARM_HALF, ARM_HALF], turn.apply([half, 0.0, ARM_HALF]), turn))
    truth = CompoundSolid(tuple(parts), RigidTransform.identity())
    return try_stated_doubt(method, _table_view(truth, rng), seed)


def _frontal(elevation_deg: float, seed: int, method: FitCallable) -> Trial:
    """Fit a box whose front is seen at a tilt, from above, so that its top shows less and less."""
    rng = _rng(seed, 5)
    truth = _standing_box([*rng.uniform(*BOX_HALF, 3)])
    view = _table_view(truth, rng, elevation=float(np.radians(elevation_deg)), azimuth=0.0)
    return try_stated_doubt(method, view, seed)


def _hidden(share_pct: float, seed: int, method: FitCallable) -> Trial:
    """Fit a box of which a board in front hides a share from one side."""
    rng = _rng(seed, 6)
    truth = _standing_box([*rng.uniform(*BOX_HALF, 3)])
    return try_stated_doubt(method, _table_view(truth, rng, hidden=share_pct / 100), seed)


def _table_view(
    truth: Superquadric | CompoundSolid,
    rng: np.random.Generator,
    *,
    surface: Mesh | None = None,
    elevation: float = ELEVATION,
    azimuth: float | None = None,
    hidden: float = 0.0,
) -> CloudView:
    """Render a solid that stands on a table at the origin, with 1 mm noise.

    Parameters
    ----------
    truth
        The true solid.
    rng
        Source of the azimuth and the noise.
    surface
        What the camera sees, if it is not the surface of the true solid.
    elevation, azimuth
        Direction from the object to the camera, rad. Default azimuth: random.
    hidden
        Share of the object's pixels that a board in front hides from the left.
    """
    around = rng.uniform(0, 2 * np.pi) if azimuth is None else azimuth
    parts = truth.parts if isinstance(truth, CompoundSolid) else (truth,)
    vertices, faces = surface or join_meshes([mesh(part, RESOLUTION) for part in parts])
    item = HouseholdMesh("stress", "stress", "other", "settings", vertices, faces)
    placed = PlacedMesh(item, RigidTransform.identity())
    middle = (vertices.min(axis=0) + vertices.max(axis=0)) / 2
    camera = look_at(middle + DISTANCE * view_direction(around, elevation), middle)
    seed = int(rng.integers(2**31))
    objects = (placed,)
    if hidden:
        alone = render_view("alone", objects, camera, 0.0, "none", seed)
        objects = (placed, _board(alone.object_pixels == 1, hidden, camera))
    view = render_view("stress", objects, camera, 0.0, "1mm", seed)
    evidence = region_evidence(view.frame, view.labels, 1, view.table.moved(camera.inv()))
    return CloudView(
        evidence.points,
        truth,
        evidence.view_origin,
        evidence.support_plane,
        evidence.free_space,
        margin=evidence.margin,
    )


def _board(mask: NDArray[np.bool_], share: float, camera: RigidTransform) -> PlacedMesh:
    """Return a board in front of an object that hides a share of its pixels (H, W), left."""
    columns = np.nonzero(mask)[1]
    edge = np.quantile(columns, min(share, 1.0 - MIN_PIXELS / len(columns)))
    k, depth = camera_intrinsics(ViewOptions()), DISTANCE / 2
    right = (float(edge) + 0.5 - k.cx) / k.fx * depth
    corners = np.array([[-1, -1, 1], [0, -1, 1], [0, 1, 1], [-1, 1, 1]]) * depth
    corners[1:3, 0] = right
    faces = np.array([[0, 1, 2], [0, 2, 3]], dtype=np.int64)
    board = HouseholdMesh("board", "stress", "other", "settings", corners, faces)
    return PlacedMesh(board, camera)


def _arc(bend: float) -> NDArray[np.float64]:
    """Return points (K, 3) of a level arc that lies on the table, m."""
    share = np.linspace(-0.5, 0.5, BEND_STEPS + 1)
    angle = bend * share
    if bend > 0:
        radius = BEND_LENGTH / bend
        x, y = radius * np.sin(angle), radius * np.cos(angle)
    else:
        x, y = BEND_LENGTH * share, np.zeros_like(share)
    return np.column_stack([x - x.mean(), y - y.mean(), np.full_like(x, BEND_RADIUS)])


def _bar(start: NDArray[np.float64], end: NDArray[np.float64], radius: float) -> Superquadric:
    """Return a cylinder between two points (3,)."""
    along = end - start
    length = float(np.linalg.norm(along))
    turn = Rotation.align_vectors([along / length], [[0.0, 0.0, 1.0]])[0]
    pose = RigidTransform.from_components((start + end) / 2, turn)
    # Pieces overlap a little, so that the bend has no gaps at its outside.
    half = np.array([radius, radius, 0.55 * length])
    return Superquadric(half, (EDGE, 1.0), pose, "cylinder")


def _standing_box(half: Sequence[float]) -> Superquadric:
    """Return a box on the table at the origin."""
    return _box(half, [0.0, 0.0, half[2]])


def _box(half: Sequence[float], centre: ArrayLike, turn: Rotation | None = None) -> Superquadric:
    pose = RigidTransform.from_components(np.array(centre), turn or Rotation.identity())
    return Superquadric(np.array(half), (EDGE, EDGE), pose, "box")


def _rng(seed: int, sweep: int) -> np.random.Generator:
    return np.random.default_rng([seed, 37, sweep])
