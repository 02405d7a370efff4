"""Depth images of household meshes that rest on a table, with the pixels of each object."""

from __future__ import annotations

import zlib
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Literal

import numpy as np
from scipy.spatial.transform import RigidTransform, Rotation

from eyehand.data_synth import DepthNoise, ViewOptions, add_depth_noise, look_at
from eyehand.data_synth.render import axial_sigma
from eyehand.data_synth.scenes import camera_intrinsics
from eyehand.errors import InputError
from eyehand.perception import CameraIntrinsics, DepthFrame, SupportPlane

from ...open3d_import import import_open3d
from .rendered_clouds import view_direction
from .resting_poses import hull_facets, resting_rotations

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from numpy.typing import NDArray

    from .household_meshes import HouseholdMesh


NoiseName = Literal["none", "1mm", "2mm", "realistic"]
"""Noise of the camera: independent with this standard deviation at the object, or that of a
structured-light camera."""
FACE_ON = "face"
"""A view along the normal of the object's largest face."""
ELEVATIONS: tuple[float | str, ...] = (35.0, 60.0)
"""Default elevations of the camera above the horizon, degrees."""
DISTANCE = 0.65
"""Distance from the camera to the middle of the object, m."""
MIN_ELEVATION, MAX_ELEVATION = 5.0, 88.0
"""Range of the elevation of a view on a face, degrees. A camera below sees the table on edge, and
straight down has no upright image."""
TABLE_HALF = (0.6, 0.5)
"""Half the length and width of the table, m."""
FLOOR = -0.75
"""Height of the floor below the table's top, m."""
MAX_RANGE = 3.0
"""Farthest reading, m."""


# Arrays have no truth value: equality is identity.
@dataclass(frozen=True, eq=False)
class PlacedMesh:
    """A mesh at a pose in the world."""

    mesh: HouseholdMesh
    """The object."""
    pose: RigidTransform
    """T_world_mesh."""


@dataclass(frozen=True, eq=False)
class MeshView:
    """A depth image of objects on a table."""

    name: str
    """Folder, name, resting pose and view of the first object."""
    placed: tuple[PlacedMesh, ...]
    """The objects. Label k of the image is object k - 1."""
    frame: DepthFrame
    """The depth image, with noise and the pose of the camera in the world, z up."""
    object_pixels: NDArray[np.uint8]
    """Label of the object that each pixel shows, (H, W); 0 = table, floor or nothing."""
    view: float | str
    """Elevation in degrees, or FACE_ON."""
    seed: int
    """Seed of the pose and the noise."""

    @property
    def mesh(self) -> HouseholdMesh:
        """The first object."""
        return self.placed[0].mesh

    @property
    def labels(self) -> NDArray[np.int32]:
        """Labels as a segmentation has them, (H, W) int32."""
        return self.object_pixels.astype(np.int32)

    @property
    def table(self) -> SupportPlane:
        """The table in the world."""
        return SupportPlane(np.array([0.0, 0.0, 1.0]), 0.0)


def mesh_views(
    meshes: Iterable[HouseholdMesh],
    views: Sequence[float | str] = ELEVATIONS,
    poses: int = 1,
    noise: NoiseName = "1mm",
    seed: int = 0,
) -> list[MeshView]:
    """Render every mesh in each of its resting poses from each view.

    Parameters
    ----------
    meshes
        The objects.
    views
        Elevations of the camera above the horizon, degrees, or FACE_ON.
    poses
        Maximum number of resting poses per mesh, the file's own first.
    noise
        Errors of the camera.
    seed
        Seed of the rotations about the vertical and of the noise. With the object's name it
        determines them.
    """
    found = []
    for mesh in meshes:
        for index, rest in enumerate(resting_rotations(mesh.vertices, poses)):
            for view in views:
                name = f"{mesh.key} pose {index} view {view}"
                own_seed = zlib.crc32(f"{seed} {mesh.key} {index} {view}".encode())
                found.append(_single_view(name, mesh, rest, view, noise, own_seed))
    return found


def render_view(
    name: str,
    placed: tuple[PlacedMesh, ...],
    T_world_camera: RigidTransform,
    view: float | str,
    noise: NoiseName,
    seed: int,
) -> MeshView:
    """Render placed objects with a camera at a pose and add noise."""
    camera = camera_intrinsics(ViewOptions())
    depth, labels = _cast(placed, camera, T_world_camera)
    distance = float(np.median(depth[labels == 1])) if np.any(labels == 1) else DISTANCE
    rng = np.random.default_rng([seed, 41])
    noisy = add_depth_noise(depth, camera, rng, _noise(noise, distance))
    return MeshView(name, placed, DepthFrame(noisy, camera, T_world_camera), labels, view, seed)


def rest_on_table(
    mesh: HouseholdMesh, rest: Rotation, yaw: float, place: tuple[float, float] = (0.0, 0.0)
) -> PlacedMesh:
    """Place a mesh with a resting rotation and a yaw, rad, on the table around a place, m."""
    turn = Rotation.from_euler("z", yaw) * rest
    turned = turn.apply(mesh.hull_vertices)
    low, high = turned.min(axis=0), turned.max(axis=0)
    shift = np.append(np.array(place) - (low + high)[:2] / 2, -low[2])
    return PlacedMesh(mesh, RigidTransform.from_components(shift, turn))


def _single_view(
    name: str,
    mesh: HouseholdMesh,
    rest: Rotation,
    view: float | str,
    noise: NoiseName,
    seed: int,
) -> MeshView:
    rng = np.random.default_rng(seed)
    placed = rest_on_table(mesh, rest, float(rng.uniform(0, 2 * np.pi)))
    vertices = placed.pose.apply(mesh.hull_vertices)
    if view == FACE_ON:
        towards = _towards_face(vertices)
    elif isinstance(view, int | float):
        towards = view_direction(rng.uniform(0, 2 * np.pi), np.radians(view))
    else:
        raise InputError(f"a view must be an elevation in degrees or {FACE_ON!r}, got {view!r}")
    middle = np.array([0.0, 0.0, vertices[:, 2].max() / 2])
    camera = look_at(middle + DISTANCE * towards, middle)
    return render_view(name, (placed,), camera, view, noise, seed)


def _towards_face(vertices: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the direction (3,) to a camera in front of the largest face that it can see."""
    normals, areas = hull_facets(vertices)
    seen = normals[:, 2] > -np.sin(np.radians(MIN_ELEVATION))
    x, y, z = normals[seen][np.argmax(areas[seen])]
    elevation = np.clip(np.degrees(np.arcsin(z)), MIN_ELEVATION, MAX_ELEVATION)
    return view_direction(float(np.arctan2(y, x)), float(np.radians(elevation)))


def _noise(name: NoiseName, distance: float) -> DepthNoise:
    match name:
        case "none":
            return DepthNoise.none()
        case "realistic":
            return DepthNoise.realistic()
        case "1mm" | "2mm":
            sigma = 0.001 if name == "1mm" else 0.002
            return DepthNoise(axial=sigma / float(axial_sigma(np.array(distance))))
    raise InputError(f"noise must be none, 1mm, 2mm or realistic, got {name!r}")


def _cast(
    placed: tuple[PlacedMesh, ...], camera: CameraIntrinsics, T_world_camera: RigidTransform
) -> tuple[NDArray[np.float32], NDArray[np.uint8]]:
    """Return the exact depth (H, W), m, and the label of each pixel (H, W)."""
    open3d = import_open3d()
    scene = open3d.t.geometry.RaycastingScene(nthreads=1)
    T_camera_world = T_world_camera.inv()
    for item in placed:
        vertices = (T_camera_world * item.pose).apply(item.mesh.vertices)
        scene.add_triangles(
            open3d.core.Tensor(vertices.astype(np.float32)),
            open3d.core.Tensor(item.mesh.faces.astype(np.uint32)),
        )
    directions = camera.rays()
    rays = np.concatenate([np.zeros_like(directions), directions], axis=-1).astype(np.float32)
    hit = scene.cast_rays(open3d.core.Tensor(rays), nthreads=1)
    # A ray has z = 1, so that the length to its hit is the depth.
    depth = hit["t_hit"].numpy().astype(np.float64)
    labels = np.where(np.isfinite(depth), hit["geometry_ids"].numpy() + 1, 0)
    eye = T_world_camera.translation
    world = directions @ T_world_camera.rotation.as_matrix().T
    with np.errstate(divide="ignore"):
        table, floor = (
            np.where(world[..., 2] < 0, (h - eye[2]) / world[..., 2], np.inf) for h in (0.0, FLOOR)
        )
    plan = eye[:2] + np.where(np.isfinite(table), table, 0.0)[..., None] * world[..., :2]
    on_table = np.all(np.abs(plan) <= TABLE_HALF, axis=-1)
    ground = np.where(on_table, table, floor)
    labels = np.where(depth < ground, labels, 0).astype(np.uint8)
    depth = np.minimum(depth, ground)
    return np.where(depth <= MAX_RANGE, depth, 0.0).astype(np.float32), labels


NEARER = 0.08
"""Distance of the occluder in front of what it hides, m."""
BESIDE = 25
"""Pixels beside the object that the occluder hides too."""
MIN_PIXELS = 100
"""Minimum number of pixels of an object that remain."""


def hide_in_turn(views: Iterable[MeshView], shares: Sequence[float]) -> list[MeshView]:
    """Hide a share of the first object of each view, in turn from a list of shares, 0-1."""
    return [hide_side(view, shares[k % len(shares)]) for k, view in enumerate(views)]


def hide_side(view: MeshView, share: float) -> MeshView:
    """Replace the readings of a share of the rows or columns of the first object by nearer ones.

    The seed of the view selects the side.
    """
    if share <= 0.0:
        return view
    mask = view.object_pixels == 1
    across = np.nonzero(mask)[view.seed % 2]
    if len(across) <= MIN_PIXELS:
        return view
    low, high = int(across.min()), int(across.max())
    kept = max(round((1.0 - share) * (high - low + 1)), 1)
    position = np.indices(mask.shape)[view.seed % 2]
    if view.seed // 2 % 2:
        kept = max(kept, int(np.quantile(across, MIN_PIXELS / len(across))) - low + 1)
        hidden = position >= low + kept
    else:
        last = int(np.quantile(across, 1.0 - MIN_PIXELS / len(across)))
        hidden = position <= min(high - kept, last - 1)
    rows, columns = np.nonzero(mask)
    around = np.zeros_like(mask)
    around[
        max(rows.min() - BESIDE, 0) : rows.max() + BESIDE,
        max(columns.min() - BESIDE, 0) : columns.max() + BESIDE,
    ] = True
    hidden &= around
    depth = view.frame.depth.copy()
    depth[hidden & (depth > NEARER)] -= NEARER
    return replace(
        view,
        name=f"{view.name} {100 * share:.0f} % hidden",
        frame=replace(view.frame, depth=depth),
        object_pixels=np.where(hidden, 0, view.object_pixels).astype(np.uint8),
    )
