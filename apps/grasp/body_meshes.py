"""Coloured meshes of the bodies of a simulated cell, for the live page."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import RigidTransform, Rotation

from eyehand.data_synth import import_mujoco

VISIBLE_GROUPS = 3
"""MuJoCo draws the geoms of groups below this number."""
DEFAULT_RGBA = (0.5, 0.5, 0.5, 1.0)
"""Colour that MuJoCo gives to a geom without a colour."""
SECTIONS = 24
"""Number of facets around a round mesh."""


def body_meshes(model: Any) -> dict[int, Any]:
    """Return a mesh for every visible body, in the frame of the body.

    Parameters
    ----------
    model
        `mujoco.MjModel`. Its planes are left out because they are infinite.

    Returns
    -------
    dict
        `trimesh.Trimesh` with a colour per vertex, by body id. Body 0 is the static world.
    """
    import trimesh
    from trimesh.visual import ColorVisuals

    parts: dict[int, list[Any]] = {}
    for geom in range(model.ngeom):
        colour = _colour(model, geom)
        if model.geom_group[geom] >= VISIBLE_GROUPS or colour[3] == 0:
            continue
        mesh = _geom_mesh(model, geom)
        if mesh is None:
            continue
        turn = Rotation.from_quat(model.geom_quat[geom], scalar_first=True)
        mesh.apply_transform(RigidTransform.from_components(model.geom_pos[geom], turn).as_matrix())
        corners = np.tile(np.round(255 * colour).astype(np.uint8), (len(mesh.vertices), 1))
        mesh.visual = ColorVisuals(mesh, vertex_colors=corners)
        parts.setdefault(int(model.geom_bodyid[geom]), []).append(mesh)
    return {body: trimesh.util.concatenate(meshes) for body, meshes in parts.items()}


def _colour(model: Any, geom: int) -> NDArray[np.float64]:
    """Return the RGBA colour (4,) in [0, 1]. A material replaces the default colour."""
    own = np.asarray(model.geom_rgba[geom], dtype=np.float64)
    material = model.geom_matid[geom]
    if material < 0 or own.tolist() != list(DEFAULT_RGBA):
        return own
    shade = np.asarray(model.mat_rgba[material], dtype=np.float64)
    texture = np.asarray(model.mat_texid[material]).max()
    if texture >= 0:
        start, width = model.tex_adr[texture], model.tex_nchannel[texture]
        size = model.tex_width[texture] * model.tex_height[texture] * width
        shade[:3] *= model.tex_data[start : start + size].reshape(-1, width).mean(axis=0) / 255
    return shade


def _geom_mesh(model: Any, geom: int) -> Any:
    """Return the uncoloured mesh of a geom in its own frame, or None for other geom types."""
    from trimesh import Trimesh, creation

    types = import_mujoco().mjtGeom
    kind, size = int(model.geom_type[geom]), model.geom_size[geom]
    if kind == types.mjGEOM_BOX:
        return creation.box(extents=2 * size)
    if kind == types.mjGEOM_CYLINDER:
        return creation.cylinder(radius=size[0], height=2 * size[1], sections=SECTIONS)
    if kind == types.mjGEOM_CAPSULE:
        mesh = creation.capsule(height=2 * size[1], radius=size[0], count=[SECTIONS // 2, SECTIONS])
        mesh.apply_translation(-mesh.bounds.mean(axis=0))
        return mesh
    if kind in (int(types.mjGEOM_SPHERE), int(types.mjGEOM_ELLIPSOID)):
        mesh = creation.icosphere(subdivisions=3)
        mesh.apply_scale(size[0] if kind == types.mjGEOM_SPHERE else size)
        return mesh
    if kind == types.mjGEOM_MESH:
        number = model.geom_dataid[geom]
        first, count = model.mesh_vertadr[number], model.mesh_vertnum[number]
        start, faces = model.mesh_faceadr[number], model.mesh_facenum[number]
        return Trimesh(
            model.mesh_vert[first : first + count].copy(),
            model.mesh_face[start : start + faces].copy(),
            process=False,
        )
    return None
