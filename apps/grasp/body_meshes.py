"""The bodies of a simulated cell as coloured meshes, for a page in the browser."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from scipy.spatial.transform import RigidTransform, Rotation

from eyehand.data_synth import import_mujoco

if TYPE_CHECKING:
    from numpy.typing import NDArray

SEEN_GROUPS = 3
"""MuJoCo draws geoms of groups below this."""
UNSAID = (0.5, 0.5, 0.5, 1.0)
"""Colour of a geom that was given none."""
SECTIONS = 24
"""Sides of what is round."""


def body_meshes(model: Any) -> dict[int, Any]:
    """Give a mesh for every body that is seen, in the body's frame.

    Parameters
    ----------
    model
        `mujoco.MjModel`; planes, which have no end, are left out.

    Returns
    -------
    dict
        `trimesh.Trimesh` with a colour per corner, by the body's number; 0 is what stands still.
    """
    import trimesh
    from trimesh.visual import ColorVisuals

    parts: dict[int, list[Any]] = {}
    for number in range(model.ngeom):
        colour = _colour(model, number)
        if model.geom_group[number] >= SEEN_GROUPS or colour[3] == 0:
            continue
        mesh = _geom_mesh(model, number)
        if mesh is None:
            continue
        turn = Rotation.from_quat(model.geom_quat[number], scalar_first=True)
        mesh.apply_transform(
            RigidTransform.from_components(model.geom_pos[number], turn).as_matrix()
        )
        corners = np.tile(np.round(255 * colour).astype(np.uint8), (len(mesh.vertices), 1))
        mesh.visual = ColorVisuals(mesh, vertex_colors=corners)
        parts.setdefault(int(model.geom_bodyid[number]), []).append(mesh)
    return {body: trimesh.util.concatenate(meshes) for body, meshes in parts.items()}


def _colour(model: Any, geom: int) -> NDArray[np.float64]:
    """Red, green, blue, opacity; a material's where the geom's own is not said, as in MuJoCo."""
    own = np.asarray(model.geom_rgba[geom], dtype=np.float64)
    material = model.geom_matid[geom]
    if material < 0 or own.tolist() != list(UNSAID):
        return own
    shade = np.asarray(model.mat_rgba[material], dtype=np.float64)
    texture = np.asarray(model.mat_texid[material]).max()
    if texture >= 0:
        start, width = model.tex_adr[texture], model.tex_nchannel[texture]
        size = model.tex_width[texture] * model.tex_height[texture] * width
        shade[:3] *= model.tex_data[start : start + size].reshape(-1, width).mean(axis=0) / 255
    return shade


def _geom_mesh(model: Any, geom: int) -> Any:
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
