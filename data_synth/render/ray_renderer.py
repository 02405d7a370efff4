"""Depth, labels and colour by casting one ray per pixel, without a graphics library."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import RigidTransform

from eyehand.perception import CameraIntrinsics

from ..mujoco_import import import_mujoco
from ..scenes.tabletop_spec import TABLE_TOP, VISIBLE_GROUPS
from ..scenes.wood_texture import wood_colour
from .rendered_view import RenderedView

SHADOW_SLACK = 1e-3
"""Share of the distance to a light at which a surface cannot shade itself."""
BACKGROUND = (0.62, 0.63, 0.65)


class RayRenderer:
    """Renderer by `mj_multiRay`: exact on primitives, slower than OpenGL on meshes."""

    def __init__(self) -> None:
        self._mujoco = import_mujoco()

    @property
    def name(self) -> str:
        """``rays``."""
        return "rays"

    def render(
        self,
        model: Any,
        data: Any,
        intrinsics: CameraIntrinsics,
        T_world_camera: RigidTransform,
        geom_labels: NDArray,
        *,
        max_range: float,
        colour: bool,
    ) -> RenderedView:
        """Render as described in :class:`DepthRenderer`."""
        shape = (intrinsics.height, intrinsics.width)
        # Rays with z = 1 in the camera frame: their length at the hit is the depth.
        rays = intrinsics.rays().reshape(-1, 3) @ T_world_camera.rotation.as_matrix().T
        eye = np.array(T_world_camera.translation)
        normals = np.zeros_like(rays) if colour else None
        depth, geom = self._cast(model, data, eye, rays, normals)
        hit = geom >= 0
        seen = hit & (depth <= max_range)
        labels = np.where(seen, geom_labels[geom], 0).astype(np.int32)
        picture = None
        if normals is not None:
            picture = np.empty((len(rays), 3))
            picture[:] = BACKGROUND
            # Light has no range: colour shows what lies past the last depth reading.
            points = eye + depth[hit, None] * rays[hit]
            picture[hit] = self._shade(model, data, eye, points, normals[hit], geom[hit])
            picture = (np.clip(picture, 0, 1) * 255).astype(np.uint8).reshape(*shape, 3)
        depth = np.where(seen, depth, 0.0).astype(np.float32).reshape(shape)
        return RenderedView(depth, labels.reshape(shape), picture)

    def _cast(
        self,
        model: Any,
        data: Any,
        origin: NDArray[np.float64],
        rays: NDArray[np.float64],
        normals: NDArray[np.float64] | None,
    ) -> tuple[NDArray[np.float64], NDArray[np.int32]]:
        """Cast rays (n, 3); return share of the ray's length (n,) and geom (n,), -1 for no hit."""
        count = len(rays)
        distance, geom = np.full(count, -1.0), np.full(count, -1, dtype=np.int32)
        groups = np.array(VISIBLE_GROUPS, dtype=np.uint8)
        self._mujoco.mj_multiRay(
            model,
            data,
            origin,
            np.ascontiguousarray(rays).reshape(-1),
            groups,
            1,
            -1,
            geom,
            distance,
            None if normals is None else normals.reshape(-1),
            count,
            self._mujoco.mjMAXVAL,
        )
        return distance, geom

    def _shade(
        self,
        model: Any,
        data: Any,
        eye: NDArray[np.float64],
        points: NDArray[np.float64],
        normals: NDArray[np.float64],
        geom: NDArray[np.int32],
    ) -> NDArray[np.float64]:
        """Compute Lambertian shading by the head light and lamps with shadows, (n, 3) in [0, 1]."""
        base = model.geom_rgba[geom, :3].astype(np.float64)
        tops = [k for k in range(model.ngeom) if model.geom(k).name == TABLE_TOP]
        for top in tops:
            on_top = geom == top
            local = (points[on_top] - data.geom_xpos[top]) @ data.geom_xmat[top].reshape(3, 3)
            base[on_top] = wood_colour(local[:, 0], local[:, 1])
        head = model.vis.headlight
        light = np.array(head.ambient) + _lambert(eye, points, normals) * np.array(head.diffuse)
        for k in range(model.nlight):
            place = np.array(data.light_xpos[k])
            light += model.light_ambient[k]
            share, _ = self._cast(model, data, place, points - place, None)
            lit = (share < 0) | (share > 1 - SHADOW_SLACK)
            light += lit[:, None] * _lambert(place, points, normals) * model.light_diffuse[k]
        return base * light


def _lambert(
    place: NDArray[np.float64], points: NDArray[np.float64], normals: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Compute the cosine between normals and the direction to a light, >= 0, (n, 1)."""
    towards = place - points
    cosine = np.einsum("ij,ij->i", normals, towards) / np.linalg.norm(towards, axis=1)
    return np.maximum(cosine, 0.0)[:, None]
